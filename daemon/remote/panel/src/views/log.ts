// The events, newest first; one node for each event in the store.
import { make } from "../dom";
import { fixed } from "../format";
import type { LogEvent } from "../protocol";
import { maxEvents, type Store } from "../store";

function item(event: LogEvent): HTMLLIElement {
    const line = make("li");
    line.dataset["kind"] = event.kind;
    line.dataset["id"] = String(event.id);
    line.append(make("time", "", `${fixed(event.t_s, 2)} s`), make("b", "", event.kind), make("span", "", event.text));
    return line;
}

export function makeLog(list: HTMLElement, store: Store): () => void {
    let shown = 0;
    return () => {
        if (store.eventCount === shown) return;
        if (store.eventCount < shown) {
            list.replaceChildren();
            shown = 0;
        }
        const fresh = Math.min(store.eventCount - shown, store.events.length);
        const added = fresh ? store.events.slice(-fresh) : [];
        const replaced = new Set(added.map((event) => String(event.id)));
        for (const line of list.querySelectorAll("li")) if (replaced.has(line.dataset["id"] ?? "")) line.remove();
        list.prepend(...added.reverse().map(item));
        while (list.childElementCount > maxEvents) list.lastElementChild?.remove();
        shown = store.eventCount;
    };
}
