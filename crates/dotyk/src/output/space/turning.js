// The view that turns: own data only. WebGL 2 where there is one, else triangles painted from back to front on a canvas.
(() => {
  const box = document.getElementById("turning");
  const data = JSON.parse(document.getElementById("turning-data").textContent);
  const bytes = (text) => Uint8Array.from(atob(text), (c) => c.charCodeAt(0)).buffer;
  const positions = new Uint16Array(bytes(data.positions));
  const displacements = new Int16Array(bytes(data.displacements));
  const values = data.quantities.map((q) => new Uint8Array(bytes(q.values)));
  // 0 where a quantity has no value
  const known = data.quantities.map((q) => (q.known ? new Uint8Array(bytes(q.known)) : null));
  const Indices = data.short ? Uint16Array : Uint32Array;
  const triangles = new Indices(bytes(data.triangles));
  const edges = new Indices(bytes(data.edges));
  let canvas = box.querySelector("canvas");
  const at = (name) => box.querySelector(`[name=${name}]`);
  const start = { azimuth: data.azimuth, lift: data.lift, zoom: 1, pan: [0, 0] };
  let view = { ...start, pan: [0, 0] };
  let quantity = 0;
  let body = -1;
  let factor = data.factor;

  const C = [
    [0.2777273272, 0.0054073445, 0.3340998053], [0.1050930431, 1.4046135299, 1.3845901626],
    [-0.3308618287, 0.2148475595, 0.095095163], [-4.6342304990, -5.7991009734, -19.3324409563],
    [6.2282699363, 14.1799333668, 56.6905526007], [4.7763849977, -13.7451453777, -65.3530326334],
    [-5.4354558559, 4.6458526122, 26.3124352496],
  ];
  const viridis = (t) => C.reduceRight((sum, row) => sum.map((s, i) => s * t + row[i]), [0, 0, 0]);

  // rows: right, up, towards the viewer
  const frame = () => {
    const [a, l] = [view.azimuth, view.lift].map((d) => (d * Math.PI) / 180);
    const [sa, ca, sl, cl] = [Math.sin(a), Math.cos(a), Math.sin(l), Math.cos(l)];
    return [[ca, sa, 0], [-sa * sl, ca * sl, cl], [sa * cl, -ca * cl, sl]];
  };
  // pixels of the canvas per unit of length
  const scale = () => view.zoom * Math.min(canvas.width / data.wide, canvas.height / data.high);
  const shown = () => data.bodies.filter((_, i) => body < 0 || body === i);

  const shaders = [
    `#version 300 es
    in vec3 p, u; in float v, k;
    uniform vec3 low, span, centre; uniform mat3 turn; uniform float unit, factor; uniform vec2 size, pan;
    uniform float near; out vec3 place; out float value, sure;
    void main() {
      vec3 x = turn * (low + p * span + factor * unit * u - centre);
      place = x; value = v; sure = k;
      gl_Position = vec4(size * x.xy + pan, -near * x.z, 1.0);
    }`,
    `#version 300 es
    precision highp float;
    in vec3 place; in float value, sure; uniform vec4 ink; uniform mat3 low3; uniform mat4 high4; out vec4 colour;
    void main() {
      if (ink.a > 0.0) { colour = ink; return; }
      vec3 n = normalize(cross(dFdx(place), dFdy(place)));
      if (n.z < 0.0) n = -n;
      float light = min(1.0, 0.6 + 0.43 * (0.5 + 0.5 * dot(n, vec3(-0.35, 0.5, 0.79))));
      float t = clamp(value, 0.0, 1.0);
      vec4 t1 = vec4(1.0, t, t * t, t * t * t);
      vec3 c = sure < 0.99 ? vec3(0.79, 0.81, 0.83)
        : clamp((high4 * t1).xyz + t * t1.w * (low3 * t1.xyz), 0.0, 1.0);
      colour = vec4(c * light, 1.0);
    }`,
  ];

  const withGl = (gl) => {
    const program = gl.createProgram();
    [gl.VERTEX_SHADER, gl.FRAGMENT_SHADER].forEach((kind, i) => {
      const shader = gl.createShader(kind);
      gl.shaderSource(shader, shaders[i]);
      gl.compileShader(shader);
      gl.attachShader(program, shader);
    });
    gl.linkProgram(program);
    if (!gl.getProgramParameter(program, gl.LINK_STATUS)) return null;
    gl.useProgram(program);
    const buffer = (target, array) => {
      const made = gl.createBuffer();
      gl.bindBuffer(target, made);
      gl.bufferData(target, array, gl.STATIC_DRAW);
      return made;
    };
    const attribute = (name, made, count, type) => {
      const place = gl.getAttribLocation(program, name);
      gl.bindBuffer(gl.ARRAY_BUFFER, made);
      gl.enableVertexAttribArray(place);
      gl.vertexAttribPointer(place, count, type, true, 0, 0);
    };
    attribute("p", buffer(gl.ARRAY_BUFFER, positions), 3, gl.UNSIGNED_SHORT);
    attribute("u", buffer(gl.ARRAY_BUFFER, displacements), 3, gl.SHORT);
    const coloured = values.map((v) => buffer(gl.ARRAY_BUFFER, v));
    const sure = known.map((v) => v && buffer(gl.ARRAY_BUFFER, v));
    const [indices, size] = [data.short ? gl.UNSIGNED_SHORT : gl.UNSIGNED_INT, Indices.BYTES_PER_ELEMENT];
    const [faces, lines] = [triangles, edges].map((a) => buffer(gl.ELEMENT_ARRAY_BUFFER, a));
    const uniform = (name) => gl.getUniformLocation(program, name);
    gl.uniform3fv(uniform("low"), data.low);
    gl.uniform3fv(uniform("span"), data.span);
    gl.uniform3fv(uniform("centre"), data.centre);
    gl.uniform1f(uniform("unit"), data.unit);
    gl.uniform1f(uniform("near"), 0.4 / data.diameter);
    gl.uniformMatrix4fv(uniform("high4"), false, C.slice(0, 4).flatMap((c) => [...c, 0]));
    gl.uniformMatrix3fv(uniform("low3"), false, C.slice(4).flat());
    gl.enable(gl.DEPTH_TEST);
    gl.depthFunc(gl.LEQUAL);
    gl.clearColor(1, 1, 1, 1);
    return () => {
      const [r, u, t] = frame();
      const s = scale();
      gl.viewport(0, 0, canvas.width, canvas.height);
      gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
      gl.uniformMatrix3fv(uniform("turn"), false, [0, 1, 2].flatMap((i) => [r[i], u[i], t[i]]));
      gl.uniform2f(uniform("size"), (2 * s) / canvas.width, (2 * s) / canvas.height);
      gl.uniform2f(uniform("pan"), ...view.pan);
      gl.uniform1f(uniform("factor"), factor);
      attribute("v", coloured[quantity], 1, gl.UNSIGNED_BYTE);
      if (sure[quantity]) attribute("k", sure[quantity], 1, gl.UNSIGNED_BYTE);
      else {
        gl.disableVertexAttribArray(gl.getAttribLocation(program, "k"));
        gl.vertexAttrib1f(gl.getAttribLocation(program, "k"), 1);
      }
      for (const b of shown()) {
        gl.enable(gl.POLYGON_OFFSET_FILL);
        gl.polygonOffset(1, 2);
        gl.uniform4f(uniform("ink"), 0, 0, 0, 0);
        gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, faces);
        gl.drawElements(gl.TRIANGLES, b.triangles[1], indices, size * b.triangles[0]);
        gl.disable(gl.POLYGON_OFFSET_FILL);
        gl.uniform4f(uniform("ink"), 0.07, 0.1, 0.13, 1);
        gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, lines);
        gl.drawElements(gl.LINES, b.edges[1], indices, size * b.edges[0]);
      }
    };
  };

  const withPaint = () => {
    const paint = canvas.getContext("2d");
    const count = positions.length / 3;
    const placed = new Float32Array(3 * count);
    return () => {
      const axes = frame();
      const s = scale();
      const middle = [canvas.width * (0.5 + 0.5 * view.pan[0]), canvas.height * (0.5 - 0.5 * view.pan[1])];
      for (let i = 0; i < count; i++) {
        const x = [0, 1, 2].map((d) => data.low[d] + (positions[3 * i + d] / 65535) * data.span[d]
          + factor * data.unit * (displacements[3 * i + d] / 32767) - data.centre[d]);
        const q = axes.map((a) => a[0] * x[0] + a[1] * x[1] + a[2] * x[2]);
        placed.set([middle[0] + s * q[0], middle[1] - s * q[1], s * q[2]], 3 * i);
      }
      const list = [];
      for (const b of shown()) {
        for (let k = b.triangles[0]; k < b.triangles[0] + b.triangles[1]; k += 3) {
          const c = [0, 1, 2].map((j) => 3 * triangles[k + j]);
          const e = [1, 2].map((j) => [0, 1, 2].map((d) => placed[c[j] + d] - placed[c[0] + d]));
          const n = [e[0][1] * e[1][2] - e[0][2] * e[1][1], e[0][2] * e[1][0] - e[0][0] * e[1][2],
            e[0][0] * e[1][1] - e[0][1] * e[1][0]];
          if (n[2] < 0) list.push([(placed[c[0] + 2] + placed[c[1] + 2] + placed[c[2] + 2]) / 3, k, n]);
        }
        // a hair nearer than their own triangles
        for (let k = b.edges[0]; k < b.edges[0] + b.edges[1]; k += 2) {
          const near = Math.max(placed[3 * edges[k] + 2], placed[3 * edges[k + 1] + 2]);
          list.push([near + 0.01 * s * data.diameter, k, null]);
        }
      }
      list.sort((a, b) => a[0] - b[0]);
      paint.fillStyle = "#fff";
      paint.fillRect(0, 0, canvas.width, canvas.height);
      for (const [, k, n] of list) {
        if (!n) {
          paint.strokeStyle = "#121a21";
          paint.beginPath();
          [edges[k], edges[k + 1]].forEach((i) => paint.lineTo(placed[3 * i], placed[3 * i + 1]));
          paint.stroke();
          continue;
        }
        const length = Math.hypot(...n);
        const light = Math.min(1, 0.6 + 0.43 * (0.5 + 0.5 * ((0.35 * n[0] + 0.5 * n[1] - 0.79 * n[2]) / length)));
        const three = [0, 1, 2].map((j) => triangles[k + j]);
        const v = three.map((i) => values[quantity][i]);
        const none = known[quantity] && three.some((i) => !known[quantity][i]);
        const c = none ? [0.79, 0.81, 0.83] : viridis((v[0] + v[1] + v[2]) / 765);
        paint.fillStyle = paint.strokeStyle = `rgb(${c.map((x) => Math.round(255 * light * Math.min(1, Math.max(0, x))))})`;
        paint.beginPath();
        three.forEach((i) => paint.lineTo(placed[3 * i], placed[3 * i + 1]));
        paint.closePath();
        paint.fill();
        paint.stroke();
      }
    };
  };

  const gl = data.plain ? null : canvas.getContext("webgl2", { antialias: true, preserveDrawingBuffer: true });
  let draw = gl && withGl(gl);
  box.dataset.drawn = draw ? "webgl" : "canvas";
  if (!draw) {
    // a canvas that has one kind of context gives no other
    if (gl) {
      const fresh = canvas.cloneNode();
      canvas.replaceWith(fresh);
      canvas = fresh;
    }
    draw = withPaint();
  }

  let waiting = false;
  const redraw = () => {
    if (waiting) return;
    waiting = true;
    requestAnimationFrame(() => {
      waiting = false;
      const dense = Math.min(2, window.devicePixelRatio || 1);
      const [w, h] = [canvas.clientWidth * dense, canvas.clientHeight * dense].map(Math.round);
      if (canvas.width !== w || canvas.height !== h) [canvas.width, canvas.height] = [w, h];
      draw();
      const axes = frame();
      box.querySelectorAll("svg [data-axis]").forEach((g, i) => {
        const [x, y] = [20 * axes[0][i], -20 * axes[1][i]];
        g.querySelector("line").setAttribute("x2", x);
        g.querySelector("line").setAttribute("y2", y);
        g.querySelector("text").setAttribute("x", 1.4 * x);
        g.querySelector("text").setAttribute("y", 1.4 * y + 4);
      });
    });
  };
  const turn = (dx, dy) => {
    view.azimuth = (view.azimuth - dx) % 360;
    view.lift = Math.max(-90, Math.min(90, view.lift + dy));
    redraw();
  };
  const zoom = (by) => {
    view.zoom = Math.max(0.3, Math.min(60, view.zoom * by));
    redraw();
  };
  const pan = (dx, dy) => {
    view.pan = [view.pan[0] + (2 * dx) / canvas.clientWidth, view.pan[1] - (2 * dy) / canvas.clientHeight];
    redraw();
  };

  const pointers = new Map();
  canvas.addEventListener("pointerdown", (e) => {
    canvas.setPointerCapture(e.pointerId);
    pointers.set(e.pointerId, [e.clientX, e.clientY]);
  });
  canvas.addEventListener("pointermove", (e) => {
    const old = pointers.get(e.pointerId);
    if (!old) return;
    const now = [e.clientX, e.clientY];
    const [dx, dy] = [now[0] - old[0], now[1] - old[1]];
    const other = [...pointers].find(([id]) => id !== e.pointerId);
    pointers.set(e.pointerId, now);
    if (other) {
      const far = (p) => Math.hypot(p[0] - other[1][0], p[1] - other[1][1]);
      zoom(far(now) / Math.max(1, far(old)));
      pan(0.5 * dx, 0.5 * dy);
    } else if (e.shiftKey || e.buttons === 2 || e.buttons === 4) pan(dx, dy);
    else turn(0.4 * dx, 0.4 * dy);
  });
  const leave = (e) => pointers.delete(e.pointerId);
  ["pointerup", "pointercancel"].forEach((name) => canvas.addEventListener(name, leave));
  canvas.addEventListener("contextmenu", (e) => e.preventDefault());
  canvas.addEventListener("wheel", (e) => {
    e.preventDefault();
    zoom(Math.exp(-0.0012 * e.deltaY));
  }, { passive: false });
  const reset = () => {
    view = { ...start, pan: [0, 0] };
    redraw();
  };
  canvas.addEventListener("keydown", (e) => {
    const keys = {
      ArrowLeft: () => turn(-6, 0), ArrowRight: () => turn(6, 0), ArrowUp: () => turn(0, 6), ArrowDown: () => turn(0, -6),
      "+": () => zoom(1.15), "=": () => zoom(1.15), "-": () => zoom(1 / 1.15), 0: reset,
    };
    if (!keys[e.key]) return;
    e.preventDefault();
    keys[e.key]();
  });
  const legend = () => {
    const q = data.quantities[quantity];
    box.querySelector(".high").textContent = q.high;
    box.querySelector(".name").textContent = q.label;
  };
  at("quantity").addEventListener("change", (e) => {
    quantity = Number(e.target.value);
    legend();
    redraw();
  });
  at("body").addEventListener("change", (e) => {
    body = Number(e.target.value);
    redraw();
  });
  at("factor").addEventListener("input", (e) => {
    factor = (data.factor * Number(e.target.value)) / 50;
    box.querySelector("output").textContent = `× ${Number(factor.toPrecision(3))}`;
    redraw();
  });
  at("reset").addEventListener("click", reset);
  new ResizeObserver(redraw).observe(canvas);
  legend();
  redraw();
})();
