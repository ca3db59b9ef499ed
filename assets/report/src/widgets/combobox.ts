// A choice between many options, with search: a text field and a list (the ARIA combobox pattern).

import { freshId, h } from "../dom";

export interface Item {
  value: string;
  label: string;
}

export function combobox(label: string, items: Item[], start: string, chosen: (value: string) => void): HTMLElement {
  let current = items.find((item) => item.value === start) ?? items[0];
  let shown: Item[] = [];
  let active = 0;

  const listId = freshId("list");
  const inputId = freshId("input");
  const list = h("ul", { id: listId, role: "listbox", class: "options", hidden: true, "aria-label": label });
  const input = h("input", {
    id: inputId,
    type: "text",
    role: "combobox",
    autocomplete: "off",
    spellcheck: "false",
    "aria-expanded": "false",
    "aria-controls": listId,
    "aria-autocomplete": "list",
    onfocus: () => input.select(),
    onclick: () => open(""),
    oninput: () => open(input.value),
    onblur: () => close(),
    onkeydown: (event: KeyboardEvent) => key(event),
  });
  input.value = current?.label ?? "";

  function open(search: string): void {
    const words = search.toLowerCase().split(/\s+/).filter(Boolean);
    shown = items.filter((item) => words.every((word) => item.label.toLowerCase().includes(word)));
    active = Math.max(0, shown.findIndex((item) => item === current));
    list.replaceChildren(
      ...shown.map((item, index) =>
        h(
          "li",
          {
            id: `${listId}-${index}`,
            role: "option",
            "aria-selected": String(item === current),
            // This event precedes the loss of focus that closes the list.
            onpointerdown: (event: PointerEvent) => {
              event.preventDefault();
              pick(item);
            },
          },
          item.label,
        ),
      ),
    );
    if (shown.length === 0) list.append(h("li", { class: "nothing" }, "No instance matches"));
    list.hidden = false;
    input.setAttribute("aria-expanded", "true");
    point();
  }

  function point(): void {
    [...list.children].forEach((line, index) => line.classList.toggle("active", index === active));
    const line = list.children[active];
    if (shown.length > 0 && line) {
      input.setAttribute("aria-activedescendant", line.id);
      line.scrollIntoView({ block: "nearest" });
    }
  }

  function close(): void {
    list.hidden = true;
    input.setAttribute("aria-expanded", "false");
    input.removeAttribute("aria-activedescendant");
    input.value = current?.label ?? "";
  }

  function pick(item: Item): void {
    const changed = item !== current;
    current = item;
    close();
    if (changed) chosen(item.value);
  }

  function key(event: KeyboardEvent): void {
    const closed = list.hidden;
    if (event.key === "ArrowDown" || event.key === "ArrowUp") {
      if (closed) open("");
      else active = (active + (event.key === "ArrowDown" ? 1 : -1) + shown.length) % Math.max(1, shown.length);
      point();
    } else if (event.key === "Enter" && !closed) {
      const item = shown[active];
      if (item) pick(item);
    } else if (event.key === "Escape" && !closed) {
      close();
    } else {
      return;
    }
    event.preventDefault();
  }

  return h(
    "div",
    { class: "field combobox" },
    h("label", { class: "field-label", for: inputId }, label),
    h("div", { class: "combobox-box" }, input, list),
  );
}
