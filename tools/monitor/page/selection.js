// The selected robot, and whether the map follows it.

export class Selection {
  constructor(onChange) {
    this.id = null;
    this.following = false;
    this.onChange = onChange;
  }

  choose(id) {
    this.id = id;
    this.onChange();
  }

  toggle(id) {
    this.choose(this.id === id ? null : id);
    if (this.id === null) this.stopFollowing();
  }

  follow(wanted) {
    this.following = wanted && this.id !== null;
    this.onChange();
  }

  stopFollowing() {
    if (this.following) this.follow(false);
  }
}
