// A choice between a few options, as a row of buttons.

import { h } from "../dom";

export interface Option<T extends string> {
  value: T;
  label: string;
  /** Shown before the label. */
  mark?: Node;
  disabled?: boolean;
  hint?: string;
}

export interface Choice<T extends string> {
  element: HTMLElement;
  /** Shows a value, or none, as chosen, without calling back. */
  set(value: T | null): void;
}

export function choice<T extends string>(
  label: string,
  options: Option<T>[],
  value: T | null,
  chosen: (value: T) => void,
  shape: "joined" | "stacked" = "joined",
): Choice<T> {
  const buttons = options.map((option) =>
    h(
      "button",
      {
        type: "button",
        disabled: option.disabled,
        title: option.hint,
        "data-value": option.value,
        onclick: () => {
          set(option.value);
          chosen(option.value);
        },
      },
      option.mark ?? null,
      h("span", {}, option.label),
    ),
  );
  const set = (now: T | null) => {
    for (const button of buttons) button.setAttribute("aria-pressed", String(button.dataset["value"] === now));
  };
  set(value);
  const element = h(
    "div",
    { class: "field" },
    h("span", { class: "field-label", "aria-hidden": "true" }, label),
    h("div", { class: `choice ${shape}`, role: "group", "aria-label": label }, ...buttons),
  );
  return { element, set };
}
