// The events, newest first; one node for each event in the store. The search hides those without its words.
import { byId, make, setHidden } from "../dom";
import { clockTimeAt, fixed } from "../format";
import type { LogEvent } from "../protocol";
import { maxEvents, type Store } from "../store";

function item(event: LogEvent): HTMLLIElement {
    const line = make("li");
    line.dataset["kind"] = event.kind;
    line.dataset["id"] = String(event.id);
    const time = make("time", "", Number.isFinite(event.at) ? clockTimeAt(event.at) : `${fixed(event.t_s, 2)} s`);
    time.title = `${fixed(event.t_s, 3)} s of master time`;
    line.append(time, make("b", "", event.kind), make("span", "", event.text));
    return line;
}

export function makeLog(list: HTMLElement, store: Store): () => void {
    const search = byId("log-search", HTMLInputElement);
    const filter = (line: HTMLElement): void => {
        const text = (line.textContent ?? "").toLowerCase();
        setHidden(line, !search.value.toLowerCase().split(/\s+/).every((word) => text.includes(word)));
    };
    search.addEventListener("input", () => list.querySelectorAll("li").forEach(filter));
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
        const lines = added.reverse().map(item);
        lines.forEach(filter);
        list.prepend(...lines);
        while (list.childElementCount > maxEvents) list.lastElementChild?.remove();
        shown = store.eventCount;
    };
}
