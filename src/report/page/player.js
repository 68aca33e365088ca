// The player of the belief: what systems believed along a trial, step by step. Reads the JSON beside it; fetches nothing.
(() => {
  'use strict';

  // Bytes of text that is compressed (zlib) and in base64.
  async function unpacked(text) {
    const packed = Uint8Array.from(atob(text), (c) => c.charCodeAt(0));
    const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream('deflate'));
    return new Uint8Array(await new Response(stream).arrayBuffer());
  }

  const element = (name, properties = {}, ...children) => {
    const made = Object.assign(document.createElement(name), properties);
    made.append(...children);
    return made;
  };
  const cssColour = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();

  async function start(root) {
    const { traces, colours, dashes, shown } = JSON.parse(root.querySelector('script[type="application/json"]').textContent);
    const find = (part) => root.querySelector(`[data-part="${part}"]`);
    const [trialChoice, slider, play, where, panels, choice, chart] =
      ['trial', 'step', 'play', 'where', 'panels', 'systems', 'chart'].map(find);
    const width = traces.cells.length;
    const mass = []; // [trial][system], bytes, or null where there is no belief
    for (const trial of traces.trials) {
      mass.push(await Promise.all(trial.systems.map((s) => (s.mass ? unpacked(s.mass) : null))));
    }
    const plan = traces.plan && { ...traces.plan, bytes: await unpacked(traces.plan.cells) };
    const state = { trial: 0, step: 0, timer: null, shown: new Set(shown) };
    const colour = (system) => (colours[system % colours.length] === '#000000' ? cssColour('--ink') : colours[system % colours.length]);
    const dash = (system) => dashes[system % dashes.length];

    // The frame that all plans share.
    const xs = traces.cells.map((c) => c[0]).concat(...traces.trials.map((t) => t.truth.map((p) => p[0])));
    const least = (values) => values.reduce((a, b) => Math.min(a, b), Infinity);
    const most = (values) => values.reduce((a, b) => Math.max(a, b), -Infinity);
    const half = traces.cell_m / 2;
    const frame = { left: least(xs) - half, right: most(xs) + half, low: 0, high: 0 };
    if (!traces.is_route) {
      const ys = traces.cells.map((c) => c[1]).concat(...traces.trials.map((t) => t.truth.map((p) => p[1])));
      // Walls stand about the ground that belongs to the grid.
      const about = plan ? 1 : 0;
      frame.left -= about;
      frame.right += about;
      Object.assign(frame, { low: least(ys) - half - about, high: most(ys) + half + about });
    }

    traces.trials.forEach((trial, index) => {
      const length = trial.travelled_m[trial.travelled_m.length - 1];
      const words = `${trial.kept_as.join(', ')} (number ${trial.number + 1}, ${length.toFixed(1)} m)`;
      trialChoice.append(element('option', { value: index, textContent: words }));
    });

    const boxes = traces.systems.map(([, title], system) => {
      const canvas = element('canvas');
      canvas.setAttribute('role', 'img');
      canvas.setAttribute('aria-label', title);
      const swatch = element('canvas', { className: 'swatch', width: 56, height: 12 });
      swatch.setAttribute('aria-hidden', 'true');
      const words = element('p', { className: 'state' });
      const box = element('section', { className: 'belief' }, element('h4', {}, swatch, title), canvas, words);
      const tick = element('input', { type: 'checkbox', checked: state.shown.has(system) });
      tick.addEventListener('change', () => {
        if (tick.checked) state.shown.add(system); else state.shown.delete(system);
        draw();
      });
      choice.append(element('label', {}, tick, ' ', title));
      panels.append(box);
      return { box, canvas, swatch, words, title };
    });

    // A canvas as wide as its box, sharp on any screen; its context, and its size in CSS pixels.
    function prepared(canvas, height) {
      const wide = Math.max(50, canvas.clientWidth || canvas.parentElement.clientWidth);
      const high = Math.round(height(wide));
      const ratio = Math.min(3, window.devicePixelRatio || 1);
      canvas.style.height = `${high}px`;
      canvas.width = Math.round(wide * ratio);
      canvas.height = Math.round(high * ratio);
      const pen = canvas.getContext('2d');
      pen.setTransform(ratio, 0, 0, ratio, 0, 0);
      pen.clearRect(0, 0, wide, high);
      return [pen, wide, high];
    }

    function axis(pen, wide, base, from, to, ink) {
      const span = to - from;
      const step = [1, 2, 5, 10, 20, 50, 100, 200, 500, 1000].find((s) => (span / s) * 42 <= wide) || span;
      pen.fillStyle = ink;
      pen.strokeStyle = ink;
      pen.font = '11px system-ui, sans-serif';
      pen.textAlign = 'center';
      pen.lineWidth = 1;
      for (let metre = Math.ceil(from / step) * step; metre <= to; metre += step) {
        const x = ((metre - from) / span) * wide;
        pen.beginPath(); pen.moveTo(x, base); pen.lineTo(x, base + 4); pen.stroke();
        pen.fillText(String(metre), Math.min(wide - 10, Math.max(8, x)), base + 15);
      }
      pen.beginPath(); pen.moveTo(0, base + 0.5); pen.lineTo(wide, base + 0.5); pen.stroke();
    }

    function drawRoute(system, canvas, bytes, trial, step) {
      const [pen, wide, high] = prepared(canvas, () => 120);
      const [base, top] = [high - 20, 8];
      const x = (metres) => ((metres - frame.left) / (frame.right - frame.left)) * wide;
      axis(pen, wide, base, frame.left, frame.right, cssColour('--faint'));
      if (bytes) {
        pen.fillStyle = colour(system);
        const bar = Math.max(1, x(frame.left + traces.cell_m) - x(frame.left));
        for (let cell = 0; cell < width; cell += 1) {
          const height = (bytes[step * width + cell] / 255) * (base - top);
          if (height > 0) pen.fillRect(x(traces.cells[cell][0]) - bar / 2, base - height, bar + 0.5, height);
        }
      }
      const answer = trial.systems[system].answer[step];
      if (answer) {
        pen.strokeStyle = colour(system);
        pen.lineWidth = 2;
        cross(pen, x(answer[0]), top + 4, 5);
      }
      const true_x = x(trial.truth[step][0]);
      pen.strokeStyle = cssColour('--ink');
      pen.fillStyle = cssColour('--ink');
      pen.setLineDash([3, 3]);
      pen.lineWidth = 1.5;
      pen.beginPath(); pen.moveTo(true_x, top); pen.lineTo(true_x, base); pen.stroke();
      pen.setLineDash([]);
      pen.beginPath(); pen.moveTo(true_x, base); pen.lineTo(true_x - 5, base + 9); pen.lineTo(true_x + 5, base + 9); pen.fill();
    }

    function cross(pen, x, y, size) {
      pen.beginPath();
      pen.moveTo(x - size, y - size); pen.lineTo(x + size, y + size);
      pen.moveTo(x - size, y + size); pen.lineTo(x + size, y - size);
      pen.stroke();
    }

    // Walls and free ground, drawn once for each size and colour scheme.
    const ground = { key: '', canvas: null };
    function groundOf(wide, high, ratio, x, y) {
      const key = [wide, high, ratio, cssColour('--ink')].join();
      if (ground.key === key) return ground.canvas;
      const made = element('canvas', { width: wide * ratio, height: high * ratio });
      const pen = made.getContext('2d');
      pen.scale(ratio, ratio);
      const block = (from_x, from_y, metres) => {
        const [left, top] = [x(from_x), y(from_y + metres)];
        pen.fillRect(left, top, Math.max(0.8, x(from_x + metres) - left), Math.max(0.8, y(from_y) - top));
      };
      pen.fillStyle = cssColour('--ground');
      traces.cells.forEach(([cx, cy]) => block(cx - half, cy - half, traces.cell_m));
      if (plan) {
        pen.fillStyle = cssColour('--faint');
        plan.bytes.forEach((byte, index) => {
          if (byte !== 2) return;
          block(plan.origin_m[0] + (index % plan.size[0]) * plan.cell_m,
            plan.origin_m[1] + Math.floor(index / plan.size[0]) * plan.cell_m, plan.cell_m);
        });
      }
      Object.assign(ground, { key, canvas: made });
      return made;
    }

    function drawPlane(system, canvas, bytes, trial, step) {
      const [across, up] = [frame.right - frame.left, frame.high - frame.low];
      const [pen, wide, high] = prepared(canvas, (w) => Math.min(560, Math.max(90, (w * up) / across)));
      const scale = Math.min(wide / across, high / up);
      const x = (metres) => wide / 2 + (metres - (frame.left + frame.right) / 2) * scale;
      const y = (metres) => high / 2 - (metres - (frame.low + frame.high) / 2) * scale;
      const ratio = canvas.width / wide;
      pen.drawImage(groundOf(wide, high, ratio, x, y), 0, 0, wide, high);
      const bar = [50, 20, 10, 5, 2, 1].find((m) => m * scale < wide / 3) || 1;
      pen.fillStyle = cssColour('--faint');
      pen.fillRect(4, high - 4, bar * scale, 2);
      pen.font = '11px system-ui, sans-serif';
      pen.textAlign = 'left';
      pen.fillText(`${bar} m`, 4, high - 8);
      if (bytes) {
        pen.fillStyle = colour(system);
        const size = traces.cell_m * scale;
        for (let cell = 0; cell < width; cell += 1) {
          const level = bytes[step * width + cell];
          if (level === 0) continue;
          pen.globalAlpha = Math.sqrt(level / 255);
          const grown = size + 2.5 * (level / 255);
          pen.fillRect(x(traces.cells[cell][0]) - grown / 2, y(traces.cells[cell][1]) - grown / 2, grown, grown);
        }
        pen.globalAlpha = 1;
      }
      pen.strokeStyle = cssColour('--ink');
      pen.lineWidth = 1;
      pen.beginPath();
      trial.truth.slice(0, step + 1).forEach(([px, py], index) => (index ? pen.lineTo(x(px), y(py)) : pen.moveTo(x(px), y(py))));
      pen.stroke();
      const [tx, ty, heading] = trial.truth[step];
      for (const [ink, line] of [[cssColour('--card'), 5], [cssColour('--ink'), 2]]) {
        pen.strokeStyle = ink;
        pen.lineWidth = line;
        pen.beginPath();
        pen.arc(x(tx), y(ty), 6, 0, 2 * Math.PI);
        pen.moveTo(x(tx), y(ty));
        pen.lineTo(x(tx) + 12 * Math.cos(heading), y(ty) - 12 * Math.sin(heading));
        pen.stroke();
      }
      const answer = trial.systems[system].answer[step];
      if (answer) {
        for (const [ink, line] of [[cssColour('--card'), 5], [colour(system), 2.5]]) {
          pen.strokeStyle = ink;
          pen.lineWidth = line;
          cross(pen, x(answer[0]), y(answer[1]), 5);
        }
      }
    }

    function drawChart(trial, systems) {
      const [pen, wide, high] = prepared(chart, () => 130);
      const [base, top] = [high - 20, 8];
      const end = trial.travelled_m[trial.travelled_m.length - 1] || 1;
      const highest = most(systems.map((s) => most(trial.systems[s].expected_error_m))) || 1;
      const x = (metres) => (metres / end) * wide;
      const y = (metres) => base - (metres / highest) * (base - top);
      axis(pen, wide, base, 0, end, cssColour('--faint'));
      find('scale').textContent = `Expected error along this trial, 0 to ${highest.toFixed(1)} m, against metres travelled`;
      pen.lineWidth = 2;
      for (const system of systems) {
        pen.strokeStyle = colour(system);
        pen.setLineDash(dash(system));
        pen.beginPath();
        trial.systems[system].expected_error_m.forEach((error, k) => {
          if (k) pen.lineTo(x(trial.travelled_m[k]), y(error)); else pen.moveTo(x(trial.travelled_m[k]), y(error));
        });
        pen.stroke();
      }
      pen.setLineDash([]);
      pen.strokeStyle = cssColour('--ink');
      pen.lineWidth = 1.5;
      const now = x(trial.travelled_m[state.step]);
      pen.beginPath(); pen.moveTo(now, 0); pen.lineTo(now, base); pen.stroke();
    }

    function inWords(seen, step) {
      const entropy = seen.entropy_nats[step];
      return [
        seen.answer[step] ? `${seen.point_error_m[step].toFixed(2)} m off` : 'no answer',
        `expects ${seen.expected_error_m[step].toFixed(2)} m`,
        ...(entropy === null ? [] : [`entropy ${entropy.toFixed(2)} nats`]),
      ].join(' · ');
    }

    function draw() {
      const trial = traces.trials[state.trial];
      const steps = trial.travelled_m.length;
      state.step = Math.max(0, Math.min(steps - 1, state.step));
      slider.max = steps - 1;
      slider.value = state.step;
      const at = `step ${state.step + 1} of ${steps}, ${trial.travelled_m[state.step].toFixed(1)} m`;
      slider.setAttribute('aria-valuetext', at);
      where.textContent = at;
      const systems = [...state.shown].sort((a, b) => a - b);
      boxes.forEach(({ box, canvas, swatch, words, title }, system) => {
        box.hidden = !state.shown.has(system);
        if (box.hidden) return;
        const seen = trial.systems[system];
        const bytes = mass[state.trial][system];
        (traces.is_route ? drawRoute : drawPlane)(system, canvas, bytes, trial, state.step);
        const pen = swatch.getContext('2d');
        pen.clearRect(0, 0, swatch.width, swatch.height);
        pen.strokeStyle = colour(system);
        pen.lineWidth = 5;
        pen.setLineDash(dash(system).map((d) => 2 * d));
        pen.beginPath(); pen.moveTo(0, 6); pen.lineTo(swatch.width, 6); pen.stroke();
        const said = inWords(seen, state.step);
        const lost = seen.is_lost[state.step];
        words.textContent = bytes ? said : `${said} · shows no belief here`;
        if (lost !== null) {
          const flag = element('strong', { className: lost ? 'flag lost' : 'flag', textContent: lost ? 'says: lost' : 'says: found' });
          words.prepend(flag, ' ');
        }
        canvas.setAttribute('aria-label', `${title}, ${at}: ${words.textContent}`);
      });
      if (systems.length) drawChart(trial, systems);
    }

    const last = () => traces.trials[state.trial].travelled_m.length - 1;
    function stop() {
      clearInterval(state.timer);
      state.timer = null;
      play.textContent = '▶ Play';
      where.setAttribute('aria-live', 'polite');
    }
    function toggle() {
      if (state.timer) return stop();
      if (state.step >= last()) state.step = 0;
      play.textContent = '❚❚ Pause';
      where.setAttribute('aria-live', 'off');
      state.timer = setInterval(() => {
        if (state.step >= last()) return stop();
        state.step += 1;
        draw();
      }, 350);
      draw();
    }
    function go(step) {
      stop();
      state.step = step;
      draw();
    }

    trialChoice.addEventListener('change', () => {
      state.trial = Number(trialChoice.value);
      go(0);
    });
    slider.addEventListener('input', () => go(Number(slider.value)));
    play.addEventListener('click', toggle);
    find('back').addEventListener('click', () => go(state.step - 1));
    find('on').addEventListener('click', () => go(state.step + 1));
    root.addEventListener('keydown', (event) => {
      const target = event.target.tagName;
      if (event.altKey || event.ctrlKey || event.metaKey || target === 'SELECT' || target === 'SUMMARY') return;
      const is_field = target === 'INPUT';
      const keys = {
        ' ': () => toggle(),
        ArrowRight: () => go(state.step + 1),
        ArrowLeft: () => go(state.step - 1),
        Home: () => go(0),
        End: () => go(last()),
      };
      if (!(event.key in keys) || (event.key === ' ' && (target === 'BUTTON' || event.target.type === 'checkbox'))) return;
      if (is_field && event.target.type !== 'range' && event.key !== ' ') return;
      event.preventDefault();
      keys[event.key]();
    });
    for (const query of ['(prefers-color-scheme: dark)', 'print']) matchMedia(query).addEventListener('change', draw);
    root.querySelector('.stage').hidden = false;
    let wide = 0;
    new ResizeObserver(() => {
      if (root.clientWidth !== wide) {
        wide = root.clientWidth;
        draw();
      }
    }).observe(root);
    draw();
    root.dataset.ready = 'yes';
  }

  for (const root of document.querySelectorAll('.player')) {
    start(root).catch((fault) => {
      root.append(element('p', { textContent: `The player can't be shown by this browser: ${fault.message}` }));
      console.error(fault);
    });
  }
})();
