// The timeline as one explores it: drawn anew for each view, from data. Without this script, and on paper, a report shows
// the whole run as a drawing. Positions on the axis are shares of it, from 0 to 1, since parts of it may be compressed.
"use strict";
const explore = (() => {
  const LANE = 20, LINE = 16, HEAD = 28, PLOT = 90, SIGN = 7, MARGIN = 14, CLOSEST_S = 0.05;
  const FACE = '12px Ubuntu,-apple-system,"Segoe UI",Roboto,"Helvetica Neue",Arial,"Liberation Sans",sans-serif';
  // A group with more lanes is folded at first.
  const MOST_LANES = 100;
  const clamp = (value, low, high) => Math.min(Math.max(value, low), high);

  /** The first index from which on a sorted list is greater than a value. */
  function beyond(list, value) {
    let [low, high] = [0, list.length];
    while (low < high) {
      const middle = (low + high) >> 1;
      if (list[middle] > value) high = middle;
      else low = middle + 1;
    }
    return low;
  }

  /** From seconds to shares of the axis, and back. */
  function scale(stretches) {
    const between = (value, [a, b, c, d]) => c + ((value - a) / (b - a || 1)) * (d - c);
    const find = (value, end) => stretches.find((stretch) => value <= stretch[end]) ?? stretches.at(-1);
    return {
      share: (seconds) => between(seconds, find(seconds, 1)),
      seconds: (share) => {
        const [a, b, c, d] = find(share, 3);
        return between(share, [c, d, a, b]);
      },
    };
  }

  const clock = (seconds) => `${seconds.toFixed(2)} s`;

  /** Shows a timeline in this figure, first with these data. Returns what shows others of the same run, for example later
      ones. A click where nothing else is asked for calls `choose` with its time in seconds. */
  function explore(root, first, choose) {
    const [stage, canvas, output] = ["explore", "explore canvas", "explore output"].map((one) => root.querySelector(`.${one}`));
    const pen = canvas.getContext("2d");
    const colors = new Map(), widths = new Map();
    const color = (name) => {
      if (!colors.has(name)) colors.set(name, getComputedStyle(document.documentElement).getPropertyValue(name));
      return colors.get(name);
    };
    const width = (text) => {
      if (!widths.has(text)) widths.set(text, pen.measureText(text).width);
      return widths.get(text);
    };
    const folded = new Set();
    let data, share, seconds, groups, events, plots;
    // `kept` is what somebody chose to see, in seconds; none for the whole run.
    let view = { from: 0, to: 1 }, kept = null, pointer = null, rows = [], size = { width: 0, height: 0 }, left = 0, waiting = false;

    /** Takes other data; what somebody chose to see stays in view. */
    function take(fresh) {
      data = fresh;
      ({ share, seconds } = scale(data.axis));
      groups = data.groups.map((group) => ({ ...group, lanes: group.lanes.map(lane) }));
      events = data.events.map(([at, words, ink, across, anchor]) => ({ at, share: share(at), words, ink, across, anchor }));
      plots = data.plots.map((plot) => {
        const points = plot.points.map(([at, value]) => [share(at), value]);
        return { ...plot, points, shares: points.map(([share]) => share) };
      });
      if (kept) look(...kept.map(share));
      else redraw();
    }

    /** A lane's bars: where each begins, and what it looks like. */
    function lane({ name, bars }) {
      const edges = new Float64Array(bars.length / 2 + 1), looks = new Int32Array(bars.length / 2);
      let at = 0;
      for (let bar = 0; bar < looks.length; bar++) {
        edges[bar] = share(at / 1000);
        looks[bar] = bars[2 * bar + 1];
        at += bars[2 * bar];
      }
      edges[looks.length] = share(at / 1000);
      return { name, edges, looks };
    }

    const x = (share) => left + ((share - view.from) / (view.to - view.from)) * (size.width - left - MARGIN);
    const at = (x) => view.from + ((x - left) / (size.width - left - MARGIN)) * (view.to - view.from);

    /** The value of a plot at a place on the axis. */
    function valueAt({ points, shares }, place) {
      const next = clamp(beyond(shares, place), 1, points.length - 1);
      const [[a, from], [b, to]] = [points[next - 1] ?? points[0], points[next] ?? points[0]];
      return from + (to - from) * clamp((place - a) / (b - a || 1), 0, 1);
    }

    /** A name, or its beginning and its end: names that begin alike stay different. */
    function fitEnds(name, room) {
      if (width(name) <= room) return name;
      const short = (kept) => `${name.slice(0, Math.ceil(kept / 2))}…${name.slice(name.length - Math.floor(kept / 2))}`;
      let kept = Math.floor((name.length * room) / width(name));
      while (kept > 0 && pen.measureText(short(kept)).width > room) kept--;
      return short(kept);
    }

    function fit(text, room) {
      if (width(text) <= room) return text;
      let end = Math.floor((text.length * room) / width(text));
      while (end > 0 && pen.measureText(`${text.slice(0, end)}…`).width > room) end--;
      if (end > 4) return `${text.slice(0, end)}…`;
      // A sign or a number.
      const first = text.split(" ", 1)[0];
      return first.length < 3 && width(first) <= room ? first : "";
    }

    function write(text, x, y, ink, align = "left", room = Infinity) {
      pen.fillStyle = color(ink);
      pen.textAlign = align;
      pen.fillText(room === Infinity ? text : fit(text, room), x, y);
    }

    /** Writes a text that lines may cross. */
    function writeOver(text, x, y, ink, align) {
      [pen.strokeStyle, pen.lineWidth, pen.textAlign] = [color("--paper"), 3, align];
      pen.strokeText(text, x, y);
      write(text, x, y, ink, align);
    }

    /** The width of the longest name of a lane that is shown. */
    function longest() {
      const shown = groups.filter(({ title }) => !folded.has(title));
      return shown.flatMap(({ lanes }) => lanes).reduce((most, { name }) => Math.max(most, width(name)), 0);
    }

    /** The rows from the top, for this width. */
    function arrange() {
      const narrow = size.width < 600;
      // As wide as the longest name, but the bars get most of it.
      left = narrow ? MARGIN : clamp(Math.ceil(longest()) + 24, 170, size.width * 0.35);
      let y = 0;
      rows = [];
      const row = (kind, height, more) => {
        rows.push({ kind, y, height, ...more });
        y += height;
      };
      row("ticks", LINE + 6);
      row("events", placed() * LINE + 4);
      for (const plot of plots) row("plot", PLOT + HEAD, { plot });
      for (const group of groups) {
        row("head", HEAD, { group });
        if (folded.has(group.title)) continue;
        for (const lane of group.lanes) row("lane", LANE + 4 + (narrow ? LINE : 0), { lane, narrow });
        for (const text of group.rest ? wrapped(group.rest) : []) row("rest", LINE, { text });
      }
      size.height = y + 6;
    }

    /** Places the events in view and their words, in as few rows as they need, and returns how many these are. What is
        marked across all lanes comes first. */
    function placed() {
      const rows = Array.from({ length: 6 }, () => []), rest = [];
      const find = (from, to) => rows.find((row) => row.every(([a, b]) => to < a || from > b));
      for (const event of events.filter(({ across }) => across).concat(events.filter(({ across }) => !across))) {
        const at = x(event.share);
        event.spot = null;
        if (at < left - SIGN || at > size.width) continue;
        const words = fit(event.words, Math.min(260, Math.max(at, size.width - at) - 2 * SIGN)), isAtEnd = at + SIGN + 3 + width(words) > size.width;
        const [from, to] = isAtEnd ? [at - SIGN - 3 - width(words), at + SIGN] : [at - SIGN, at + SIGN + 8 + width(words)];
        // A last row has what has no room.
        const room = find(from, to), row = room ?? find(at - SIGN, at + SIGN) ?? rest;
        row.push(room ? [from, to] : [at - SIGN, at + SIGN]);
        event.spot = [at, LINE + 6 + (row === rest ? rows.length : rows.indexOf(row)) * LINE + LINE / 2];
        event.label = room ? [words, isAtEnd ? at - SIGN - 3 : at + SIGN + 3, isAtEnd ? "right" : "left"] : null;
      }
      return rest.length ? rows.length + 1 : rows.findLastIndex((row) => row.length) + 1;
    }

    function wrapped(text) {
      const lines = [];
      for (const word of text.split(" ")) {
        const longer = lines.length ? `${lines.at(-1)} ${word}` : word;
        if (lines.length && width(longer) <= size.width - left - MARGIN) lines[lines.length - 1] = longer;
        else lines.push(word);
      }
      return lines;
    }

    /** Times to be labeled: as many as there is room for, at round numbers. */
    function ticks() {
      const all = [];
      let free = -Infinity;
      for (const [from, to, , , compressed] of data.axis) {
        const [a, b] = [Math.max(x(share(from)), left), Math.min(x(share(to)), size.width - MARGIN)];
        if (b <= a || compressed) continue;
        const [first, last] = [seconds(at(a)), seconds(at(b))];
        const rough = ((last - first) / (b - a)) * 64, power = 10 ** Math.floor(Math.log10(rough));
        const step = power * [1, 2, 5, 10].find((factor) => factor * power >= rough);
        for (let tick = Math.ceil(first / step); tick * step <= last; tick++) {
          const place = x(share(tick * step));
          if (place - free < 50) continue;
          all.push([place, `${+(tick * step).toFixed(3)} s`]);
          free = place;
        }
      }
      return all;
    }

    function grid() {
      for (const [from, to, , , compressed] of data.axis) {
        if (!compressed) continue;
        pen.fillStyle = color("--idle-light");
        pen.fillRect(x(share(from)), LINE, x(share(to)) - x(share(from)), size.height);
      }
      pen.fillStyle = color("--rule");
      for (const [place] of ticks()) pen.fillRect(place, LINE + 2, 1, size.height);
      for (const [from, to] of data.held) {
        pen.fillStyle = color("--bad-light");
        pen.globalAlpha = 0.5;
        pen.fillRect(x(share(from)), LINE, Math.max(x(share(to)) - x(share(from)), 1), size.height);
        pen.globalAlpha = 1;
      }
    }

    function drawEvents(row) {
      const seen = events.filter(({ spot }) => spot);
      for (const { spot, ink, across } of seen) {
        pen.fillStyle = color(ink);
        if (across) pen.fillRect(spot[0] - 0.5, row.y, 1, size.height);
      }
      for (const { spot, label, ink } of seen) {
        pen.fillStyle = color(ink);
        pen.beginPath();
        pen.arc(...spot, SIGN - 1, 0, 7);
        pen.fill();
        if (label) writeOver(label[0], label[1], spot[1], ink, label[2]);
      }
    }

    function drawPlot({ plot, y: top }) {
      const { points, range: [low, high] } = plot, right = size.width - MARGIN;
      const y = (value) => top + HEAD - 4 + (PLOT - 8) * (1 - clamp((value - low) / (high - low), 0, 1));
      write(plot.title, 1, top + HEAD / 2, "--ink");
      for (const value of plot.ticks) {
        pen.fillStyle = color("--rule");
        pen.fillRect(left, y(value), right - left, 1);
        if (left > 40) write(String(+value.toFixed(3)), left - 6, y(value), "--muted", "right");
        else write(String(+value.toFixed(3)), left + 2, y(value) + (value === plot.ticks.at(-1) ? 8 : -7), "--muted");
      }
      pen.save();
      pen.beginPath();
      pen.rect(left, top + HEAD - 6, right - left, PLOT);
      pen.clip();
      pen.beginPath();
      for (let point = Math.max(beyond(plot.shares, view.from) - 1, 0); point < points.length; point++) {
        pen.lineTo(x(points[point][0]), y(points[point][1]));
        if (points[point][0] > view.to) break;
      }
      pen.strokeStyle = color("--ink");
      pen.lineWidth = 2;
      pen.stroke();
      let above = -Infinity;
      for (const [value, label, critical] of plot.bounds) {
        const ink = critical ? "--bad" : "--busy-dark", isBelow = y(value) - above < 20 || y(value) < top + HEAD + 6;
        const beside = y(value) + (isBelow ? 8 : -8);
        [pen.strokeStyle, pen.lineWidth] = [color(critical ? "--bad" : "--busy"), 1];
        pen.setLineDash([5, 4]);
        pen.strokeRect(left, y(value), size.width, 0);
        pen.setLineDash([]);
        // At the end where the curve is farther away.
        const room = pen.measureText(label).width + 8;
        const distance = (end) => {
          const places = [0, 0.25, 0.5, 0.75, 1].map((part) => (end === "right" ? right - room : left) + part * room);
          return Math.min(...places.map((place) => Math.abs(y(valueAt(plot, at(place))) - beside)));
        };
        const end = distance("right") < 10 && distance("left") > distance("right") ? "left" : "right";
        writeOver(label, end === "right" ? right - 4 : left + 4, beside, ink, end);
        above = y(value);
      }
      pen.restore();
    }

    function drawLane({ lane, y, narrow }) {
      const top = y + (narrow ? LINE : 0);
      if (narrow) write(fitEnds(lane.name, size.width - left), left, y + LINE / 2, "--muted");
      else write(fitEnds(lane.name, left - 14), left - 10, y + LANE / 2, "--muted", "right");
      const [low, high] = [left, size.width - MARGIN];
      let crowd = null;
      const crowded = () => {
        if (crowd) {
          pen.fillStyle = color(data.looks[crowd[2]]?.[2] ?? "--line");
          pen.fillRect(crowd[0], top, Math.max(crowd[1] - crowd[0], 1), LANE - 1);
        }
        crowd = null;
      };
      for (let bar = Math.max(beyond(lane.edges, view.from) - 1, 0); bar < lane.looks.length; bar++) {
        if (lane.edges[bar] >= view.to) break;
        if (lane.looks[bar] < 0) continue;
        const [a, b] = [clamp(x(lane.edges[bar]), low, high), clamp(x(lane.edges[bar + 1]), low, high)];
        if (b - a < 3) {
          // Changes that follow each other too quickly have a color if all of them look alike.
          const look = lane.looks[bar];
          if (crowd && a - crowd[1] < 1) crowd = [crowd[0], b, crowd[2] === look ? look : -1];
          else {
            crowded();
            crowd = [a, b, look];
          }
          continue;
        }
        crowded();
        const [text, ground, outline, ink] = data.looks[lane.looks[bar]];
        if (!ground) {
          pen.fillStyle = color("--rule");
          pen.fillRect(a + 2, top + LANE / 2, Math.max(b - a - 4, 1), 1.5);
          continue;
        }
        pen.beginPath();
        pen.roundRect(a + 0.5, top, b - a - 1, LANE - 1, 3.5);
        pen.fillStyle = color(ground);
        pen.fill();
        [pen.strokeStyle, pen.lineWidth] = [color(outline), 1];
        pen.stroke();
        if (b - a > 16) write(text, a + 6, top + LANE / 2, ink, "left", b - a - 9);
      }
      crowded();
    }

    function draw() {
      waiting = false;
      const wide = stage.clientWidth;
      if (!wide) return;
      size.width = wide;
      pen.font = FACE;
      arrange();
      const ratio = window.devicePixelRatio || 1;
      if (canvas.width !== Math.round(wide * ratio) || canvas.height !== Math.round(size.height * ratio)) {
        [canvas.width, canvas.height] = [Math.round(wide * ratio), Math.round(size.height * ratio)];
        canvas.style.height = `${size.height}px`;
      }
      pen.setTransform(ratio, 0, 0, ratio, 0, 0);
      pen.clearRect(0, 0, wide, size.height);
      pen.font = FACE;
      pen.textBaseline = "middle";
      pen.save();
      pen.beginPath();
      pen.rect(left - 1, 0, wide - left - MARGIN + 2, size.height);
      pen.clip();
      grid();
      pen.restore();
      for (const row of rows) {
        if (row.kind === "ticks") for (const [place, text] of ticks()) write(text, place, LINE / 2, "--muted", "center");
        if (row.kind === "events") drawEvents(row);
        if (row.kind === "plot") drawPlot(row);
        if (row.kind === "head") write(`${folded.has(row.group.title) ? `▸ ${row.group.title}: ${row.group.lanes.length}` : `▾ ${row.group.title}`}`, 1, row.y + HEAD / 2, "--ink");
        if (row.kind === "lane") drawLane(row);
        if (row.kind === "rest") write(row.text, left, row.y + LINE / 2, "--muted");
      }
      if (pointer) {
        pen.fillStyle = color("--muted");
        pen.fillRect(clamp(x(share(pointer.at)), left, wide - MARGIN), LINE, 1, size.height);
      }
    }

    function redraw() {
      if (!waiting) requestAnimationFrame(draw);
      waiting = true;
    }

    /** Shows this part of the axis from now on. */
    function show(from, to) {
      look(from, to);
      kept = view.from <= 0 && view.to >= 1 ? null : [seconds(view.from), seconds(view.to)];
    }

    /** Shows this part of the axis, or as much of it as there is. */
    function look(from, to) {
      const closest = Math.min(CLOSEST_S / (data.end || 1), 1), length = clamp(to - from, closest, 1);
      const middle = (from + to) / 2, begin = clamp(middle - length / 2, 0, 1 - length);
      view = { from: begin, to: begin + length };
      redraw();
    }

    function zoom(factor, around) {
      const length = (view.to - view.from) * factor, part = (around - view.from) / (view.to - view.from);
      show(around - part * length, around + (1 - part) * length);
    }

    const pan = (part) => show(view.from + part * (view.to - view.from), view.to + part * (view.to - view.from));

    /** Zooms to a moment, and says what happened there. */
    function visit(moment) {
      const half = Math.min(0.05, 10 / (data.end || 1)), place = share(moment);
      show(place - half, place + half);
      pointer = { at: moment };
      say(moment, rows.find((row) => row.kind === "events"));
    }

    /** What is at this time in this row, in words. */
    function say(moment, row) {
      const words = [clock(moment)];
      if (data.began) words.push(`${new Date(data.began + moment * 1000).toISOString().replace("T", " ").replace("Z", "")} UTC`);
      const near = events.filter((event) => Math.abs(x(event.share) - x(share(moment))) < SIGN);
      if (row?.kind === "lane") {
        const { name, edges, looks } = row.lane, bar = clamp(beyond(edges, share(moment)) - 1, 0, looks.length - 1);
        const text = looks[bar] < 0 ? "" : data.looks[looks[bar]][0];
        words.push(`${name}: ${text || "–"}, from ${clock(seconds(edges[bar]))} to ${clock(seconds(edges[bar + 1]))}`);
      }
      for (const plot of row?.kind === "plot" ? [row.plot] : plots.slice(0, 1)) {
        const value = valueAt(plot, share(moment)), [least, most] = plot.range;
        words.push(`${plot.title}: ${value.toFixed(most - least > 20 ? 1 : 3)}`);
      }
      output.textContent = words.concat(near.map((event) => event.words)).join(" · ");
    }

    const rowAt = (y) => rows.find((row) => y >= row.y && y < row.y + row.height);
    const eventAt = ({ x, y }) => events.find(({ spot }) => spot && Math.hypot(spot[0] - x, spot[1] - y) <= SIGN + 2);
    const place = (event) => {
      const box = canvas.getBoundingClientRect();
      return { x: event.clientX - box.left, y: event.clientY - box.top };
    };

    const fingers = new Map();
    let dragged = 0;
    canvas.addEventListener("pointerdown", (event) => {
      canvas.focus({ preventScroll: true });
      canvas.setPointerCapture(event.pointerId);
      fingers.set(event.pointerId, place(event));
      dragged = 0;
    });
    canvas.addEventListener("pointermove", (event) => {
      const spot = place(event), before = fingers.get(event.pointerId);
      if (before) {
        const other = [...fingers].find(([finger]) => finger !== event.pointerId)?.[1];
        if (other) {
          const [was, is] = [before, spot].map((one) => Math.max(Math.abs(one.x - other.x), 10));
          zoom(was / is, at(other.x));
        } else pan((before.x - spot.x) / (size.width - left - MARGIN));
        dragged += Math.abs(before.x - spot.x);
        fingers.set(event.pointerId, spot);
      }
      const row = rowAt(spot.y);
      canvas.style.cursor = row?.kind === "head" || eventAt(spot)?.anchor ? "pointer" : fingers.size ? "grabbing" : "grab";
      pointer = spot.x < left ? null : { at: seconds(clamp(at(spot.x), 0, 1)) };
      if (pointer) say(pointer.at, row);
      else if (row?.kind === "lane") output.textContent = row.lane.name;
      redraw();
    });
    for (const end of ["pointerup", "pointercancel"]) canvas.addEventListener(end, (event) => fingers.delete(event.pointerId));
    canvas.addEventListener("pointerleave", () => {
      pointer = null;
      redraw();
    });
    canvas.addEventListener("click", (event) => {
      if (dragged > 4) return;
      const found = eventAt(place(event)), row = rowAt(place(event).y);
      if (found?.anchor) location.hash = found.anchor;
      else if (row?.kind === "head") {
        if (!folded.delete(row.group.title)) folded.add(row.group.title);
      } else if (place(event).x >= left) choose?.(seconds(clamp(at(place(event).x), 0, 1)));
      redraw();
    });
    canvas.addEventListener("dblclick", () => show(0, 1));
    // A page scrolls until one has turned to the timeline.
    canvas.addEventListener("wheel", (event) => {
      if (!event.ctrlKey && document.activeElement !== canvas) return;
      event.preventDefault();
      if (Math.abs(event.deltaX) > Math.abs(event.deltaY)) pan(event.deltaX / size.width);
      else zoom(Math.exp(clamp(event.deltaY, -240, 240) * 0.002), clamp(at(place(event).x), view.from, view.to));
    }, { passive: false });
    const middle = () => (view.from + view.to) / 2;
    const keys = {
      "+": () => zoom(0.7, middle()),
      "=": () => zoom(0.7, middle()),
      "-": () => zoom(1 / 0.7, middle()),
      ArrowLeft: () => pan(-0.1),
      ArrowRight: () => pan(0.1),
      0: () => show(0, 1),
      Home: () => show(0, 1),
      Escape: () => show(0, 1),
      ",": () => step(-1),
      ".": () => step(1),
    };
    let stepped = -1;
    function step(by) {
      if (!events.length) return;
      stepped = clamp(stepped + by, 0, events.length - 1);
      visit(events[stepped].at);
    }
    canvas.addEventListener("keydown", (event) => {
      if (!keys[event.key] || event.ctrlKey || event.metaKey || event.altKey) return;
      event.preventDefault();
      event.stopPropagation();
      keys[event.key]();
    });
    for (const button of stage.querySelectorAll("button")) button.addEventListener("click", () => keys[button.value]());
    document.addEventListener("click", (event) => {
      const link = event.target.closest("a[data-at]");
      if (link) visit(Number(link.dataset.at));
    });
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => {
      colors.clear();
      redraw();
    });
    new ResizeObserver(redraw).observe(stage);
    root.classList.add("explored");
    take(first);
    for (const { title, lanes } of groups) if (lanes.length > MOST_LANES) folded.add(title);
    draw();
    return take;
  }

  return explore;
})();
for (const root of document.querySelectorAll(".timeline")) {
  const data = root.querySelector("script");
  if (data) explore(root, JSON.parse(data.textContent));
}
