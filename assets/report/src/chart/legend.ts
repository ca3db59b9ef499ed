// The legend: a click hides a solver; a double-click or Alt-click shows it alone.

import type { Solver } from "../data";
import { h, s } from "../dom";
import { ink, onThemeChange } from "../theme";
import { swatch } from "./draw";

export interface Legend {
  element: HTMLElement;
  /** Sets the solvers that are drawn, and those without values to draw. */
  offer(present: Solver[], absent: Solver[]): void;
}

export function legend(hidden: Set<string>, changed: () => void): Legend {
  const list = h("div", { class: "legend-list" });
  const all = h("button", { type: "button", class: "plain", onclick: () => { hidden.clear(); update(); } }, "Show all");
  const element = h(
    "div",
    { class: "legend", role: "group", "aria-label": "Solvers in the chart" },
    list,
    all,
    h("p", { class: "hint" }, "Click a solver to hide it; double-click (or Alt-click) to show it alone."),
  );
  let buttons: { id: string; button: HTMLButtonElement }[] = [];
  let offered: { present: Solver[]; absent: Solver[] } = { present: [], absent: [] };

  function update(): void {
    for (const { id, button } of buttons) button.setAttribute("aria-pressed", String(!hidden.has(id)));
    all.hidden = !buttons.some(({ id }) => hidden.has(id));
    changed();
  }

  function isolate(id: string): void {
    const isolated = buttons.every((entry) => hidden.has(entry.id) === (entry.id !== id));
    hidden.clear();
    if (!isolated) for (const entry of buttons) if (entry.id !== id) hidden.add(entry.id);
    update();
  }

  function entry(solver: Solver, absent: boolean): HTMLButtonElement {
    const line = s("svg", { width: 30, height: 12, "aria-hidden": "true" });
    line.append(swatch(solver.style, ink()));
    return h(
      "button",
      {
        type: "button",
        class: "entry",
        disabled: absent,
        title: absent ? "no value on these axes" : null,
        "data-solver": solver.id,
        onclick: (event: MouseEvent) => {
          if (event.altKey) return isolate(solver.id);
          if (!hidden.delete(solver.id)) hidden.add(solver.id);
          update();
        },
        ondblclick: () => isolate(solver.id),
      },
      line,
      h("span", {}, solver.label),
    );
  }

  function offer(present: Solver[], absent: Solver[]): void {
    offered = { present, absent };
    buttons = present.map((solver) => ({ id: solver.id, button: entry(solver, false) }));
    list.replaceChildren(...buttons.map(({ button }) => button), ...absent.map((solver) => entry(solver, true)));
    for (const { id, button } of buttons) button.setAttribute("aria-pressed", String(!hidden.has(id)));
    all.hidden = !buttons.some(({ id }) => hidden.has(id));
  }

  onThemeChange(() => offer(offered.present, offered.absent));
  return { element, offer };
}
