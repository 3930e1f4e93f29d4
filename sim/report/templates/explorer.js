// The explorer: choices in a form, mirrored in the address, drawn by Vega-Lite.
(() => {
  const section = document.getElementById("explore");
  if (!section) return;
  const form = section.querySelector("form");
  const picture = document.getElementById("explorer-picture");
  const output = form.querySelector("output");
  // Longest list of values to choose from; most points whose bars can be told apart.
  const MOST_VALUES = 12, MOST_BARS = 2000;
  // Most values of a number that have a colour each.
  const MOST_COLOURS = 8;
  const CHANNELS = ["x", "y", "colour", "size", "panels"];
  let systems, system, columns, links, curves, view, drawing = Promise.resolve();

  async function inflate(id) {
    const bytes = Uint8Array.from(atob(document.getElementById(id).textContent), (c) => c.charCodeAt(0));
    const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"));
    return new Response(stream).text();
  }

  async function start() {
    systems = JSON.parse(await inflate("explorer-data"));
    const script = document.createElement("script");
    script.textContent = await inflate("drawing-program");
    document.head.append(script);
    const choice = readAddress();
    buildForm(Object.hasOwn(systems, choice.get("system")) ? choice.get("system") : Object.keys(systems)[0]);
    apply(choice);
    update(false);
  }

  // The form.
  // A point may be in several series.
  const distinct = (column) => [...new Set(column.values.flat().filter((value) => value !== null))];
  const isNumber = (column) => column && column.kind !== "word";
  const ascending = (values) => values.sort((a, b) => (typeof a === "number" ? a - b : String(a).localeCompare(b)));

  function addSelect(parent, name, label, options, initial) {
    const select = document.createElement("select");
    select.name = name;
    for (const [value, text] of options) select.add(new Option(text, value, value === initial, value === initial));
    addLabel(parent, label, select);
  }

  function addLabel(parent, text, ...elements) {
    const label = document.createElement("label");
    label.append(`${text} `, ...elements);
    parent.append(label, " ");
  }

  function buildForm(name) {
    system = name;
    ({ columns, links, curves } = systems[name]);
    columns = Object.fromEntries(columns.map((column) => [column.name, column]));
    const all = Object.values(columns);
    const numbers = all.filter(isNumber).map((column) => [column.name, column.label]);
    const few = all.filter((column) => distinct(column).length <= MOST_VALUES && distinct(column).length > 1);
    const none = [["", "none"]];
    const parameters = all.filter((column) => column.kind === "parameter");
    const second = parameters.find((column) => column !== parameters[0] && distinct(column).length > 1);
    const choices = section.querySelector("[data-choices]");
    choices.replaceChildren();
    if (Object.keys(systems).length > 1) addSelect(choices, "system", "System", Object.keys(systems).map((one) => [one, one]), name);
    addSelect(choices, "x", "x", numbers, parameters[0]?.name);
    const observed = columns.velocity ?? all.find((column) => column.kind === "observable");
    addSelect(choices, "y", "y", numbers, observed?.name);
    addSelect(choices, "colour", "Colour", [...none, ...all.map((c) => [c.name, c.label])], second?.name ?? "regime");
    addSelect(choices, "size", "Size", [...none, ...numbers], "");
    addSelect(choices, "panels", "Panels", [...none, ...few.map((c) => [c.name, c.label])], "");
    const filters = section.querySelector("[data-filters]");
    filters.replaceChildren();
    for (const column of all.filter((one) => one.kind !== "observable" && distinct(one).length > 1)) {
      const values = ascending(distinct(column));
      if (values.length <= MOST_VALUES || !isNumber(column)) {
        addSelect(filters, `is.${column.name}`, column.label, [["", "all"], ...values.map((v) => [String(v), String(v)])], "");
      } else {
        addLabel(filters, column.label, ...["from", "to"].map((end) => {
          const input = document.createElement("input");
          Object.assign(input, { type: "number", step: "any", name: `${end}.${column.name}`, placeholder: end, size: 8 });
          input.setAttribute("aria-label", `${column.label} ${end}`);
          return input;
        }));
      }
    }
  }

  // The address.
  function readAddress() {
    const [place, query] = location.hash.split("?");
    return new URLSearchParams(place === "#explore" ? query : "");
  }

  function apply(choice) {
    for (const [name, value] of choice) {
      const field = [...form.elements].find((one) => one.name === name);
      if (!field || name === "system") continue;
      if (field.type === "checkbox") field.checked = value === "1";
      else if (!field.matches("select") || [...field.options].some((option) => option.value === value)) field.value = value;
    }
    form.querySelector("details").open = [...choice.keys()].some((name) => name.includes("."));
  }

  function address() {
    const choice = new URLSearchParams();
    for (const field of form.elements) {
      if (!field.name) continue;
      if (field.type === "checkbox" ? field.checked : field.value) choice.set(field.name, field.type === "checkbox" ? "1" : field.value);
    }
    return choice;
  }

  // The rows.
  function passes(row) {
    for (const field of form.elements) {
      const [test, name] = field.name.split(/\.(.*)/s);
      if (!name || !field.value || !(name in columns)) continue;
      const value = columns[name].values[row];
      if (test === "is" && ![value].flat().map(String).includes(field.value)) return false;
      if (test === "from" && !(value >= Number(field.value))) return false;
      if (test === "to" && !(value <= Number(field.value))) return false;
    }
    return true;
  }

  const shownRows = () => links.map((_, row) => row).filter(passes);

  function datum(row, chosen) {
    const record = { row };
    for (const name of ["regime", ...Object.values(columns).filter((c) => c.kind === "parameter").map((c) => c.name), ...chosen]) {
      const value = columns[name]?.values[row];
      if (value !== undefined) record[name] = Array.isArray(value) ? value.join(", ") : value;
    }
    for (const [axis, name] of [["x", chosen[0]], ["y", chosen[1]]]) {
      const { values, half } = columns[name];
      const width = half?.[row];
      if (values[row] === null || width == null) continue;
      record[`${axis}_low`] = values[row] - width;
      record[`${axis}_high`] = values[row] + width;
      record[`${axis}_half`] = width;
    }
    return record;
  }

  // The picture.
  const escaped = (name) => name.replace(/[.[\]\\]/g, "\\$&");

  function channel(name, extra = {}) {
    const column = columns[name];
    return { field: escaped(name), type: isNumber(column) ? "quantitative" : "nominal", title: column.label, ...extra };
  }

  function position(name, log, values) {
    return channel(name, { scale: log && values.every((value) => value > 0) ? { type: "log", nice: false, padding: 8 } : { zero: false, padding: 8 } });
  }

  function specification(choice, rows) {
    const chosen = CHANNELS.map((name) => choice.get(name)).filter((name) => name in columns);
    const [x, y] = [choice.get("x"), choice.get("y")];
    const data = rows.map((row) => datum(row, [x, y, ...chosen])).filter((one) => one[x] !== null && one[y] !== null);
    const at = (name) => data.map((one) => one[name]);
    const encoding = { x: position(x, choice.has("logx"), at(x)), y: position(y, choice.has("logy"), at(y)) };
    const colour = choice.get("colour");
    if (colour) {
      const isScale = isNumber(columns[colour]) && distinct(columns[colour]).length > MOST_COLOURS;
      encoding.color = channel(colour, isScale ? { scale: { scheme: "viridis" } } : { type: "nominal" });
    }
    // No axis of logarithms holds the whole of a bar that reaches 0.
    const floor = (axis) => (encoding[axis].scale.type === "log" ? Math.min(...at(choice.get(axis))) / 2 : -Infinity);
    const floors = { x: floor("x"), y: floor("y") };
    for (const one of data) for (const axis of ["x", "y"]) {
      if (`${axis}_low` in one) one[`${axis}_low`] = Math.max(one[`${axis}_low`], floors[axis]);
    }
    const bars = ["x", "y"].filter((axis) => data.length <= MOST_BARS && data.some((one) => `${axis}_half` in one)).map((axis) => ({
      mark: { type: "rule", opacity: 0.5 },
      encoding: {
        ...encoding,
        [axis]: { ...encoding[axis], field: `${axis}_low` },
        [`${axis}2`]: { field: `${axis}_high` },
      },
    }));
    const names = [...new Set([...Object.keys(data[0] ?? {}).filter((name) => name in columns), x, y])];
    const paint = colour ? encoding.color : { value: ink("--link") };
    const marks = {
      mark: { type: "point", filled: false, strokeWidth: 1.5, cursor: "pointer" },
      encoding: {
        ...encoding,
        size: choice.get("size") ? channel(choice.get("size"), { scale: { range: [15, 400] } }) : { value: 45 },
        opacity: { value: 1 },
        // As in figures, no bar shows through an open mark.
        fill: { condition: { test: "datum.regime === 'steady'", ...paint }, value: ink("--page") },
        tooltip: [
          ...names.map((name) => channel(name)),
          ...["x", "y"].filter((a) => data.some((one) => `${a}_half` in one)).map((a) => ({ field: `${a}_half`, title: `± of ${choice.get(a)}` })),
        ],
      },
    };
    if (!colour) marks.encoding.stroke = { value: ink("--link") };
    const line = { mark: { type: "line", opacity: 0.6 }, encoding };
    const sections = shownCurves(choice);
    section.querySelector("[data-notes]").innerHTML = sections.map((one) => one.note).join(" ");
    const layer = [...sections.flatMap((one) => curveLayers(one, encoding, colour, floors.y)), ...bars, ...(choice.has("lines") ? [line] : []), marks];
    const panels = choice.get("panels");
    const isNarrow = section.clientWidth < 600;
    const space = section.clientWidth - 75 - (!isNarrow && (colour || choice.get("size")) ? 140 : 0);
    const columnsOfPanels = panels ? Math.max(1, Math.min(3, Math.floor(space / 230))) : 1;
    const width = Math.max(140, space / columnsOfPanels - (panels ? 35 : 0));
    const one = { layer, width, height: panels ? 220 : Math.max(260, Math.min(460, space * 0.6)) };
    return {
      data: { values: data },
      config: theme(isNarrow),
      ...(panels ? { facet: { ...channel(panels), type: "nominal" }, columns: columnsOfPanels, spec: one } : one),
    };
  }

  // Panels hold other values than a section does.
  function shownCurves(choice) {
    if (choice.get("panels")) return [];
    return curves.filter((one) => one.x === choice.get("x") && one.y === choice.get("y"));
  }

  function curveLayers(curve, encoding, colour, floor) {
    const mine = colour in curve.rows[0] && colour !== curve.x ? encoding.color : { value: ink("--soft") };
    const rows = curve.rows.filter((row) => row.mean > floor).map((row) => ({ ...row, low: Math.max(row.low, floor) }));
    const shared = { x: encoding.x, color: mine, detail: { field: "part" } };
    const height = (field) => ({ ...encoding.y, field });
    const layer = (mark, more) => ({ data: { values: rows }, mark, encoding: { ...shared, ...more } });
    return [
      layer({ type: "area", opacity: 0.18 }, { y: height("low"), y2: { field: "high" } }),
      layer({ type: "line" }, { y: height("mean"), strokeDash: { condition: { test: "datum.likely", value: [1, 0] }, value: [4, 3] } }),
    ];
  }

  const ink = (name) => {
    const probe = document.createElement("span");
    probe.style.color = `var(${name})`;
    section.append(probe);
    const colour = getComputedStyle(probe).color;
    probe.remove();
    return colour;
  };

  // Light text stands on a dark page.
  const isDark = () => parseInt(ink("--text").match(/\d+/)[0], 10) > 128;

  function theme(isNarrow) {
    const [text, line] = [ink("--text"), ink("--line")];
    return {
      background: "transparent", view: { stroke: line }, font: "system-ui, sans-serif",
      axis: { labelColor: text, titleColor: text, gridColor: line, domainColor: text, tickColor: text, labelFontSize: 12, titleFontSize: 13, titleFontWeight: 400, labelOverlap: true, labelSeparation: 8 },
      legend: { labelColor: text, titleColor: text, labelFontSize: 12, titleFontWeight: 400, titleLimit: 130, orient: isNarrow ? "bottom" : "right", gradientOpacity: 1, symbolOpacity: 1, ...(isNarrow ? { columns: 2 } : {}) },
      header: { labelColor: text, titleColor: text, labelFontSize: 12 },
    };
  }

  async function draw() {
    const choice = address(), rows = shownRows();
    output.textContent = `${rows.length} of ${links.length} points`;
    document.getElementById("explorer-text").textContent =
      `${columns[choice.get("y")].label} against ${columns[choice.get("x")].label}, ${rows.length} points`;
    const options = { actions: false, ast: true, renderer: "canvas", tooltip: { theme: isDark() ? "dark" : "light" } };
    const result = await vegaEmbed(picture, specification(choice, rows), options);
    view?.finalize();
    picture.classList.toggle("dark", isDark());
    view = result.view;
    width = section.clientWidth;
    view.addEventListener("click", (_, item) => {
      if (item?.datum?.row === undefined) return;
      location.href = links[item.datum.row];
    });
  }

  function update(mirror = true) {
    if (mirror) history.replaceState(null, "", `#explore?${address()}`);
    drawing = drawing.then(draw);
    return drawing;
  }

  form.addEventListener("submit", (event) => event.preventDefault());
  form.addEventListener("change", (event) => {
    if (event.target.name === "system") buildForm(event.target.value);
    update();
  });
  form.addEventListener("reset", () => setTimeout(() => update()));

  // What leaves the page.
  function save(name, href) {
    const link = document.createElement("a");
    Object.assign(link, { download: name, href });
    link.click();
  }

  function rowsAsCsv() {
    const all = Object.values(columns);
    const heads = all.flatMap((column) => [column.label, ...(column.half ? [`half width of ${column.label}`] : [])]);
    const lines = shownRows().map((row) => all.flatMap((c) => [c.values[row], ...(c.half ? [c.half[row]] : [])]));
    const cell = (value) => {
      const text = value === null || value === undefined ? "" : String(value);
      return /[",\n]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text;
    };
    return [heads, ...lines].map((line) => line.map(cell).join(",")).join("\n");
  }

  for (const button of all("[data-save]", section)) {
    button.addEventListener("click", async () => {
      await drawing;
      const kind = button.dataset.save;
      const name = `${document.title.split(" – ")[0]}-explorer.${kind}`;
      if (kind === "csv") save(name, URL.createObjectURL(new Blob([rowsAsCsv()], { type: "text/csv" })));
      else save(name, await view.toImageURL(kind, 2));
    });
  }

  // Draw when it is first seen, again when its width or the theme changes.
  let width = 0;
  const begin = () => {
    begun ??= start();
    return begun;
  };
  let begun;
  new IntersectionObserver((entries, observer) => {
    if (!entries.some((entry) => entry.isIntersecting)) return;
    observer.disconnect();
    begin();
  }, { rootMargin: "400px" }).observe(section);
  new ResizeObserver(() => {
    if (!view || Math.abs(section.clientWidth - width) < 20) return;
    width = section.clientWidth;
    update(false);
  }).observe(section);
  const redraw = () => view && update(false);
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", redraw);
  themeButton.addEventListener("click", redraw);
  addEventListener("hashchange", async () => {
    const choice = readAddress();
    if (![...choice].length) return;
    await begin();
    if (Object.hasOwn(systems, choice.get("system"))) buildForm(choice.get("system"));
    apply(choice);
    update(false);
  });
  if ([...readAddress()].length) begin().then(() => section.scrollIntoView());
})();
