// Pointers, wheel and keys on the map. One finger or the mouse pans, drags or aims, as `hand` decides; two fingers
// zoom.

const STEP = 0.15;

export function gestures(floor, place) {
  const { hand, svg } = floor;
  const pointers = new Map();
  let press = null;

  const spread = () => {
    const [a, b] = [...pointers.values()];
    return Math.hypot(a.clientX - b.clientX, a.clientY - b.clientY);
  };
  // The picture may be narrower or lower than the place for it.
  const share = ({ clientX, clientY }) => {
    const at = new DOMPoint(clientX, clientY).matrixTransform(svg.getScreenCTM().inverse());
    return [(at.x - floor.box[0]) / floor.box[2], (at.y - floor.box[1]) / floor.box[3]];
  };
  const click = (point, thing) => {
    if (hand.aims()) hand.goal(point, null, floor.pose);
    else hand.clicked(point, thing);
  };
  const letGo = () => {
    press = null;
    floor.clearDraft();
  };

  svg.addEventListener('pointerdown', event => {
    if (event.button) return;
    svg.setPointerCapture(event.pointerId);
    pointers.set(event.pointerId, event);
    if (pointers.size === 2) {
      letGo();
      press = { pinch: spread() };
    } else if (pointers.size === 1) {
      const point = floor.point(event);
      const thing = floor.thing(point);
      const does = hand.aims() ? 'aim' : hand.holds(thing) ? 'drag' : 'pan';
      press = { event, point, thing, does, box: floor.box, moved: false };
    }
  });

  svg.addEventListener('pointermove', event => {
    if (!pointers.has(event.pointerId) || !press) return;
    pointers.set(event.pointerId, event);
    if (press.pinch) {
      const now = spread();
      floor.zoom(press.pinch / now, share(event));
      press.pinch = now;
      return;
    }
    const [dx, dy] = [event.clientX - press.event.clientX, event.clientY - press.event.clientY];
    press.moved ||= Math.hypot(dx, dy) > 4;
    if (!press.moved) return;
    if (press.does === 'aim') floor.aim(press.point, floor.point(event));
    else if (press.does === 'drag') floor.draft(press.thing, floor.point(event));
    else {
      const { width, height } = svg.getBoundingClientRect();
      const scale = Math.max(press.box[2] / width, press.box[3] / height);
      floor.follow(false);
      floor.look([press.box[0] - dx * scale, press.box[1] - dy * scale, press.box[2], press.box[3]]);
    }
  });

  svg.addEventListener('pointerup', event => {
    pointers.delete(event.pointerId);
    if (!press || press.pinch) return letGo();
    const { does, moved, point, thing } = press;
    const to = floor.point(event);
    if (!moved) click(point, thing);
    else if (does === 'aim') hand.goal(point, to, floor.pose);
    else if (does === 'drag') hand.moved(thing, to);
    letGo();
  });

  svg.addEventListener('pointercancel', event => {
    pointers.delete(event.pointerId);
    letGo();
  });

  svg.addEventListener('wheel', event => {
    event.preventDefault();
    floor.zoom(event.deltaY < 0 ? 1 / 1.2 : 1.2, share(event));
  }, { passive: false });

  const keys = {
    '+': () => floor.zoom(1 / 1.2),
    '-': () => floor.zoom(1.2),
    0: () => floor.all(),
    f: () => floor.follow(),
    ArrowLeft: () => floor.pan(-STEP, 0),
    ArrowRight: () => floor.pan(STEP, 0),
    ArrowUp: () => floor.pan(0, -STEP),
    ArrowDown: () => floor.pan(0, STEP),
    Enter: () => {
      const box = svg.getBoundingClientRect();
      const point = floor.point({ clientX: box.x + box.width / 2, clientY: box.y + box.height / 2 });
      click(point, floor.thing(point));
    },
    Escape: letGo,
  };
  place.onkeydown = event => {
    const act = event.ctrlKey || event.metaKey ? null : keys[event.key];
    if (!act) return;
    event.preventDefault();
    act();
  };
}
