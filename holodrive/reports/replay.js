// Replays of the runs in this page. No library, no network: data lies beside each player as JSON.
"use strict";
(() => {
  const UNKNOWN = 65535;
  const calm = window.matchMedia("(prefers-reduced-motion: reduce)");

  /** 16-bit numbers in base64 -> rows of floats (see reports/replay.py, pack). */
  function unpack(packed) {
    const bytes = Uint8Array.from(atob(packed.data), (c) => c.charCodeAt(0));
    const view = new DataView(bytes.buffer);
    const k = packed.k;
    const flat = new Float64Array(bytes.length / 2);
    for (let i = 0; i < flat.length; i++) {
      const n = view.getUint16(2 * i, true);
      flat[i] = n === UNKNOWN ? NaN : packed.low[i % k] + packed.step[i % k] * n;
    }
    return { k, n: k ? flat.length / k : 0, at: (row, column = 0) => flat[row * k + column] };
  }

  /** Last row whose time is at most t, and how far the next one is along (0..1). */
  function find(times, t) {
    let a = 0, b = times.n - 1;
    if (b < 1 || t <= times.at(0)) return [0, 0];
    if (t >= times.at(b)) return [b, 0];
    while (b - a > 1) {
      const middle = (a + b) >> 1;
      if (times.at(middle) <= t) a = middle; else b = middle;
    }
    return [a, (t - times.at(a)) / (times.at(a + 1) - times.at(a) || 1)];
  }

  function between(table, [row, share], column) {
    const a = table.at(row, column);
    return share ? a + share * (table.at(row + 1, column) - a) : a;
  }

  function number(value, digits) {
    if (!Number.isFinite(value)) return "—";
    const text = value.toFixed(digits);
    return (Number(text) === 0 ? text.replace("-", "") : text).replace("-", "−");
  }

  function length(metres) {
    return Math.abs(metres) >= 1 ? `${number(metres, 3)} m` : `${number(1e3 * metres, 1)} mm`;
  }

  /** An arrow from (x, y) by (dx, dy) pixels, nothing when it is too short to be seen. */
  function arrow(x, y, dx, dy) {
    const length = Math.hypot(dx, dy);
    if (!(length > 1.5)) return "";
    const head = Math.min(8, 0.6 * length), ux = dx / length, uy = dy / length;
    const tip = [x + dx, y + dy];
    const side = (s) => `${(tip[0] - head * ux + s * 0.55 * head * uy).toFixed(1)} ${(tip[1] - head * uy - s * 0.55 * head * ux).toFixed(1)}`;
    const end = `${tip[0].toFixed(1)} ${tip[1].toFixed(1)}`;
    return `M${x.toFixed(1)} ${y.toFixed(1)}L${end}M${side(1)}L${end}L${side(-1)}`;
  }

  function place(mover, t) {
    const path = mover.path, first = path[0][0], last = path[path.length - 1][0];
    if (mover.loop && last > first && t > first) t = first + ((((t - first) % (last - first)) + (last - first)) % (last - first));
    if (t <= first) return path[0].slice(1);
    for (let i = 1; i < path.length; i++) {
      if (t <= path[i][0]) {
        const share = (t - path[i - 1][0]) / (path[i][0] - path[i - 1][0] || 1);
        return [1, 2].map((j) => path[i - 1][j] + share * (path[i][j] - path[i - 1][j]));
      }
    }
    return path[path.length - 1].slice(1);
  }

  function player(root) {
    const data = JSON.parse(root.querySelector("script[type='application/json']").textContent);
    const section = root.closest("section") || root;
    const one = (selector) => root.querySelector(selector);
    const scene = one("svg.scene"), live = one(".live"), close = one("svg.close-up");
    const slider = one(".timeline"), button = one(".play"), speed = one(".speed"), clock = one(".clock"), state = one(".state");
    const v = data.view;
    const px = (x) => v.left + (x - v.x) * v.scale, py = (y) => v.base - (y - v.y) * v.scale;
    const tables = ["time", "pose", "error", "twist", "commands", "speeds", "steer", "drift"];
    const tracks = data.tracks.map((raw, i) => {
      const track = { ...raw, robot: live.querySelector(`.live-robot.r${i}`), trail: live.querySelector(`.trail.r${i}`) };
      for (const name of tables) if (raw[name]) track[name] = unpack(raw[name]);
      if (raw.scans) {
        track.scans = { beams: raw.scans.beams };
        for (const name of ["time", "origin", "x", "y"]) track.scans[name] = unpack(raw.scans[name]);
      }
      track.dots = Array.from({ length: track.pose.n }, (_, row) => {
        const x = track.pose.at(row, 0), y = track.pose.at(row, 1);
        return Number.isFinite(x + y) ? `${px(x).toFixed(1)} ${py(y).toFixed(1)}` : "";
      });
      return track;
    });
    const start = Math.min(...tracks.map((track) => track.time.at(0)));
    const end = Math.max(...tracks.map((track) => track.end));
    const movers = [...live.querySelectorAll(".live-mover")];
    const cursors = [...section.querySelectorAll("svg.chart[data-time]")].map((chart) => {
      const line = document.createElementNS("http://www.w3.org/2000/svg", "path");
      line.setAttribute("class", "cursor");
      chart.append(line);
      const d = chart.dataset;
      const [x0, x1, y0, y1, t0, t1] = [d.x0, d.x1, d.y0, d.y1, d.t0, d.t1].map(Number);
      chart.addEventListener("pointerdown", (event) => {
        const box = chart.getBoundingClientRect();
        const x = ((event.clientX - box.left) / box.width) * chart.viewBox.baseVal.width;
        if (x >= x0 && x <= x1) seek(t0 + ((x - x0) / (x1 - x0)) * (t1 - t0));
      });
      return (t) => {
        const x = x0 + ((t - t0) / (t1 - t0 || 1)) * (x1 - x0);
        line.setAttribute("d", x >= x0 && x <= x1 ? `M${x.toFixed(1)} ${y0}V${y1}` : "");
      };
    });
    let now = start, playing = false, touched = false, last = 0, handle = 0;

    slider.min = 0;
    slider.max = 1000;
    slider.step = 1;

    function drawTrack(track, t) {
      const at = find(track.time, t);
      const [x, y, theta] = [0, 1, 2].map((i) => between(track.pose, at, i));
      const known = Number.isFinite(x + y + theta);
      track.robot.setAttribute("visibility", known ? "inherit" : "hidden");
      if (!known) return at;
      track.robot.setAttribute(
        "transform",
        `translate(${px(x).toFixed(2)} ${py(y).toFixed(2)})scale(${v.scale} ${-v.scale})rotate(${((theta * 180) / Math.PI).toFixed(2)})`,
      );
      const dots = track.dots.slice(0, at[0] + 1).filter(Boolean);
      track.trail.setAttribute("d", dots.length ? `M${dots.join("L")}L${px(x).toFixed(1)} ${py(y).toFixed(1)}` : "");
      return at;
    }

    function drawScan(scans, t) {
      const [row] = find(scans.time, t);
      const on = one(".lidar")?.checked && t >= scans.time.at(0);
      let beams = "", hits = "";
      if (on) {
        const from = `M${px(scans.origin.at(row, 0)).toFixed(1)} ${py(scans.origin.at(row, 1)).toFixed(1)}L`;
        for (let i = row * scans.beams; i < (row + 1) * scans.beams; i++) {
          const x = scans.x.at(i), y = scans.y.at(i);
          if (!Number.isFinite(x + y)) continue;
          const end = `${px(x).toFixed(1)} ${py(y).toFixed(1)}`;
          beams += from + end;
          hits += `M${end}h0`;
        }
      }
      one(".beams").setAttribute("d", beams);
      one(".hits").setAttribute("d", hits);
    }

    function drawCloseUp(track, at) {
      const { scale, centre } = data.close;
      let steered = 0;
      track.wheels.forEach((wheel, i) => {
        let yaw = wheel.yaw;
        if (wheel.steered) {
          const angle = track.steer.at(at[0], steered++);
          yaw += Number.isFinite(angle) ? angle : 0;
          for (const drawing of [close, track.robot]) {
            drawing.querySelector(`.wheel[data-wheel="${i}"]`).setAttribute(
              "transform", `translate(${wheel.x} ${wheel.y})rotate(${((yaw * 180) / Math.PI).toFixed(2)})`);
          }
        }
        const x = centre - wheel.y * scale, y = centre - wheel.x * scale;
        for (const [kind, table] of [["commanded", track.commands], ["measured", track.speeds]]) {
          const share = (table.at(at[0], i) / (wheel.top || 1)) * 0.3 * centre;
          close.querySelector(`.${kind}[data-wheel="${i}"]`).setAttribute("d", arrow(x, y, -Math.sin(yaw) * share, -Math.cos(yaw) * share));
          const cell = one(`td.${kind}[data-wheel="${i}"]`);
          if (cell) cell.textContent = number(table.at(at[0], i), 2);
        }
      });
      const [vx, vy] = [0, 1].map((i) => (track.twist.at(at[0], i) / (track.top_speed || 1)) * 0.45 * centre);
      close.querySelector(".velocity").setAttribute("d", arrow(centre, centre, -vy, -vx));
    }

    function tell(track, at) {
      const say = (name, text) => { const cell = one(`[data-value="${name}"]`); if (cell) cell.textContent = text; };
      const [x, y, theta] = [0, 1, 2].map((i) => between(track.pose, at, i));
      const turn = Math.atan2(Math.sin(theta), Math.cos(theta));
      say("pose", `${number(x, 3)}, ${number(y, 3)} m`);
      say("heading", `${number((turn * 180) / Math.PI, 1)}°`);
      say("speed", `${number(Math.hypot(track.twist.at(at[0], 0), track.twist.at(at[0], 1)), 3)} m/s`);
      say("error", length(track.error.at(at[0])));
      if (track.drift) say("drift", length(track.drift.at(at[0])));
    }

    function show(t) {
      now = Math.min(Math.max(t, start), end);
      if (touched) scene.classList.add("playing"); // fades the still picture
      live.setAttribute("visibility", "visible");
      tracks.forEach((track) => {
        const at = drawTrack(track, now);
        if (track.wheels) {
          drawCloseUp(track, at);
          tell(track, at);
          if (track.scans) drawScan(track.scans, now);
        }
      });
      data.movers.forEach((mover, i) => {
        const [x, y] = place(mover, now);
        movers[i].setAttribute("transform", `translate(${px(x).toFixed(1)} ${py(y).toFixed(1)})`);
      });
      cursors.forEach((draw) => draw(now));
      slider.value = String(Math.round((1000 * (now - start)) / (end - start || 1)));
      slider.setAttribute("aria-valuetext", `${number(now, 1)} seconds`);
      clock.textContent = `${number(now, 2)} / ${number(end, 2)} s`;
    }

    function step(stamp) {
      if (!playing) return;
      const wait = calm.matches ? 250 : 0; // fewer, larger steps for those who asked for less motion
      if (stamp - last >= wait) {
        const passed = last ? Math.min(0.3, (stamp - last) / 1000) : 0;
        last = stamp;
        show(now + passed * Number(speed.value));
        if (now >= end) return play(false);
      }
      handle = requestAnimationFrame(step);
    }

    function play(on) {
      playing = on;
      button.textContent = on ? "Pause" : "Play";
      button.setAttribute("aria-pressed", String(on));
      state.textContent = on ? "playing" : `paused at ${number(now, 1)} seconds`;
      cancelAnimationFrame(handle);
      if (on) {
        if (now >= end || !touched) now = start; // the still shown first lies in the middle of the run
        touched = true;
        last = 0;
        handle = requestAnimationFrame(step);
      }
    }

    /** Go to a time because someone asked for it; playing goes on from there. */
    function seek(t) {
      touched = true;
      show(t);
      if (!playing) state.textContent = `at ${number(now, 1)} seconds`;
    }

    button.addEventListener("click", () => play(!playing));
    slider.addEventListener("input", () => { seek(start + (slider.value / 1000) * (end - start)); });
    one(".lidar")?.addEventListener("change", () => show(now));
    root.addEventListener("keydown", (event) => {
      if (event.target.matches("select, input[type=checkbox]") || event.ctrlKey || event.metaKey || event.altKey) return;
      const jump = event.shiftKey ? 0.1 : 1;
      const keys = {
        " ": () => { if (event.target !== button) play(!playing); else return false; },
        k: () => play(!playing),
        ArrowLeft: () => seek(now - jump),
        ArrowRight: () => seek(now + jump),
        Home: () => seek(start),
        End: () => seek(end),
      };
      if (keys[event.key] && keys[event.key]() !== false) event.preventDefault();
    });
    const marks = one(".event-marks");
    data.events.forEach((event) => {
      const mark = document.createElement("button");
      mark.type = "button";
      mark.className = `event-tick ${event.kind === "arrived" ? "good" : ""}`;
      mark.title = `${number(event.t, 2)} s: ${event.text}`;
      mark.setAttribute("aria-label", mark.title);
      mark.style.left = `${(100 * (event.t - start)) / (end - start || 1)}%`;
      mark.addEventListener("click", () => seek(event.t));
      marks.append(mark);
    });
    section.querySelectorAll("button[data-seek]").forEach((link) => {
      link.addEventListener("click", () => { seek(Number(link.dataset.seek)); root.scrollIntoView({ block: "nearest" }); });
    });
    root.classList.add("ready");
    show(start + 0.4 * (end - start));
    return { seek, play, get now() { return now; } };
  }

  const players = [...document.querySelectorAll(".replay")].map(player);
  document.documentElement.dataset.replay = "ready";
  document.documentElement.dataset.players = String(players.length);
  window.holodrive = { players };
})();
