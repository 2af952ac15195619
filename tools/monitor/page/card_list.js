// The cards in the order of the robots' names; the selected one is open, or all.

import { RobotCard } from "./robot_card.js";

export class CardList {
  constructor(box, team, actions, selection) {
    this.box = box;
    this.team = team;
    this.actions = actions;
    this.selection = selection;
    this.cards = new Map();
    this.all = false;
  }

  clear() {
    this.cards.clear();
    this.box.replaceChildren();
  }

  show() {
    for (const [id, card] of this.cards) {
      if (this.team.robots.has(id)) continue;
      card.root.remove();
      this.cards.delete(id);
    }
    for (const robot of this.team.ordered) {
      const card = this.card(robot);
      const chosen = this.selection.id === robot.id;
      if (card.open !== (this.all || chosen)) card.setOpen(this.all || chosen);
      card.update(this.team.now, chosen);
    }
  }

  card(robot) {
    const known = this.cards.get(robot.id);
    if (known?.robot === robot) return known;
    known?.root.remove();
    const card = new RobotCard(robot, this.actions, () => this.selection.toggle(robot.id));
    card.setOpen(false);
    this.cards.set(robot.id, card);
    const after = [...this.box.children].find((other) => other.dataset.robot.localeCompare(robot.id, undefined, { numeric: true }) > 0);
    this.box.insertBefore(card.root, after ?? null);
    return card;
  }

  reveal(id) {
    this.cards.get(id)?.root.scrollIntoView({ block: "nearest" });
  }
}
