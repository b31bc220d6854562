// The parts of a drawing are described: after a click, or one by one with the arrow keys.

const STEPS = { ArrowLeft: -1, ArrowUp: -1, ArrowRight: 1, ArrowDown: 1 };

// Parts have a number as this attribute; `describe` gets it. Returns what marks
// the chosen part in a new drawing, what chooses one, and what says which one is chosen.
export function parts(place, attribute, describe) {
  let chosen = null;
  const all = () => [...place.querySelectorAll(`[${attribute}]`)];
  const number = part => Number(part.getAttribute(attribute));
  const mark = () => all().forEach(part => part.classList.toggle('chosen', number(part) === chosen));
  const choose = wanted => {
    chosen = wanted;
    mark();
    all().find(part => number(part) === chosen)?.scrollIntoView({ block: 'nearest', inline: 'nearest' });
    describe(chosen);
  };
  place.addEventListener('click', ({ clientX, clientY }) => {
    // The pressed part may have been drawn again, and gets no click then.
    const part = document.elementFromPoint(clientX, clientY)?.closest(`[${attribute}]`);
    if (place.contains(part)) choose(number(part));
  });
  place.addEventListener('keydown', event => {
    const step = event.ctrlKey || event.metaKey || event.altKey ? null : STEPS[event.key];
    const known = all();
    if (!step || !known.length) return;
    event.preventDefault();
    const at = known.findIndex(part => number(part) === chosen);
    const part = known.at(at < 0 ? Math.min(step, 0) : (at + step) % known.length);
    choose(number(part));
  });
  return { mark, choose, chosen: () => chosen };
}
