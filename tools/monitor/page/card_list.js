// The cards of the listed robots; the selected one is open, or all.

import { RobotCard } from "./robot_card.js";

export class CardList {
  constructor(box, team, actions, roster, selection) {
    this.box = box;
    this.team = team;
    this.actions = actions;
    this.roster = roster;
    this.selection = selection;
    this.cards = new Map();
    this.all = false;
  }

  clear() {
    this.cards.clear();
    this.box.replaceChildren();
  }

  show() {
    const order = this.roster.listed();
    const listed = new Set(order.map((robot) => robot.id));
    for (const [id, card] of this.cards) {
      if (this.team.robots.has(id) && listed.has(id)) continue;
      card.root.remove();
      this.cards.delete(id);
    }
    const worst = this.team.troubles();
    for (const robot of order) {
      const card = this.card(robot);
      const chosen = this.selection.id === robot.id;
      if (card.open !== (this.all || chosen)) card.setOpen(this.all || chosen);
      card.update(this.team.now, { chosen, trouble: worst.get(robot.id) ?? "", pinned: this.roster.pinned.has(robot.id) });
    }
    this.arrange(order);
  }

  onPin(id, wanted) {
    this.roster.pin(id, wanted);
    this.show();
  }

  card(robot) {
    const known = this.cards.get(robot.id);
    if (known?.robot === robot) return known;
    known?.root.remove();
    const card = new RobotCard(robot, this.actions, this.roster.zones, {
      choose: () => this.selection.toggle(robot.id),
      pin: (wanted) => this.onPin(robot.id, wanted),
    });
    card.setOpen(false);
    this.cards.set(robot.id, card);
    this.box.append(card.root);
    return card;
  }

  // Moves only cards out of place: moving one takes the keyboard focus away.
  arrange(order) {
    let before = null;
    for (const robot of order) {
      const { root } = this.cards.get(robot.id);
      const expected = before ? before.nextElementSibling : this.box.firstElementChild;
      if (expected !== root) this.box.insertBefore(root, expected);
      before = root;
    }
  }

  reveal(id) {
    this.cards.get(id)?.root.scrollIntoView({ block: "nearest" });
  }
}
