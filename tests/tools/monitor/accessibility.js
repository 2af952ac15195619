// Run in the page by accessibility.py: function poorContrasts(least), function smallTargets().

const channel = (value) => (value / 255 <= 0.04045 ? value / 255 / 12.92 : ((value / 255 + 0.055) / 1.055) ** 2.4);
const luminance = ([r, g, b]) => 0.2126 * channel(r) + 0.7152 * channel(g) + 0.0722 * channel(b);
const parsed = (text) => text.match(/[\d.]+/g).map(Number);
const over = ([r, g, b, a = 1], below) => [r, g, b].map((value, k) => a * value + (1 - a) * below[k]);
const opacity = (node) => (node ? Number(getComputedStyle(node).opacity) * opacity(node.parentElement) : 1);
const shown = (node) => node.checkVisibility({ visibilityProperty: true });

function ground(node) {
  const layers = [];
  for (let at = node; at; at = at.parentElement) layers.push(parsed(getComputedStyle(at).backgroundColor));
  return layers.reverse().reduce((below, layer) => over(layer, below), [255, 255, 255]);
}

function poorContrasts(least) {
  const poor = new Set();
  const walker = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
  while (walker.nextNode()) {
    const words = walker.currentNode.data.trim();
    const node = walker.currentNode.parentElement;
    if (!words || !shown(node) || node.closest("option, script, style")) continue;
    const below = ground(node);
    const [r, g, b, a = 1] = parsed(getComputedStyle(node).color);
    const text = over([r, g, b, a * opacity(node)], below);
    const [light, dark] = [luminance(text), luminance(below)].sort((x, y) => y - x);
    const contrast = (light + 0.05) / (dark + 0.05);
    if (contrast < least) poor.add(`${contrast.toFixed(2)} ${words.slice(0, 40)}`);
  }
  return [...poor];
}

// Controls of less than 24 x 24 px with another within 12 px of their middle (WCAG 2.2, 2.5.8).
function smallTargets() {
  const boxes = [...document.querySelectorAll("button, select, summary, input, a")]
    .filter(shown).map((node) => [node, node.getBoundingClientRect()]).filter(([, box]) => box.width && box.height);
  const crowded = ([node, box]) => {
    const [x, y] = [box.x + box.width / 2, box.y + box.height / 2];
    return boxes.some(([other, there]) => {
      const dx = Math.max(there.left - x, x - there.right, 0);
      const dy = Math.max(there.top - y, y - there.bottom, 0);
      return other !== node && Math.hypot(dx, dy) < 12;
    });
  };
  return boxes.filter(([node, box]) => (box.width < 24 || box.height < 24) && crowded([node, box]))
    .map(([node]) => node.id || node.textContent || node.className);
}
