// What the details panel shows about things on the map.

import { degrees, meters, point } from './details.js';
import { distance, extent } from './floor.js';

// Describes a thing that `floor` shows now, with what `hand` and the latest frame know about it.
export function about(thing, floor, hand, frame) {
  const away = at => floor.pose ? meters(distance(at, floor.pose)) : null;
  switch (thing.is) {
    case 'robot': return () => ['Robot', [
      ['position', floor.pose && point(floor.pose)],
      ['heading', floor.pose && degrees(floor.pose[2])],
      ['believes it is at', floor.estimate && `${point(floor.estimate)}, ${degrees(floor.estimate[2])}`],
      ['localization error', floor.pose && floor.estimate && meters(distance(floor.pose, floor.estimate))],
      ['radius', meters(floor.radius_m)],
      ['battery', charge(frame().battery)],
      ['navigation', frame().navigation],
    ]];
    case 'body': return () => {
      const body = floor.bodies.find(({ name }) => name === thing.name);
      return body && [body.name, [
        ['shape', body.radius_m ? `round, radius ${meters(body.radius_m)}` : body.size_m.map(meters).join(' × ')],
        ['position', point(body.at)],
        ['heading', body.radius_m ? null : degrees(body.at[2])],
        ['from the robot', away(body.at)],
        ['placed by hand', hand.placed(body.name)?.words],
      ]];
    };
    case 'place': {
      const { name, corners } = thing;
      const sides = [0, 1].map(axis => corners.map(corner => corner[axis]));
      const ends = sides.map(all => [Math.min(...all), Math.max(...all)]);
      const center = ends.map(([low, high]) => (low + high) / 2);
      return () => [name, [
        ['kind', corners.length < 3 ? 'a point' : `an area of ${extent(thing).toFixed(2)} m²`],
        [corners.length < 3 ? 'position' : 'middle', point(center)],
        ['size', corners.length < 3 ? null : ends.map(([low, high]) => meters(high - low)).join(' × ')],
        ['from the robot', away(center)],
      ]];
    }
    default: return () => ['Floor', [['position', point(thing.at)], ['from the robot', away(thing.at)]]];
  }
}

function charge(battery) {
  return battery && `${battery.pct.toFixed(1)} %${battery.charging ? ', charging' : ''}`;
}
