// The recordings in the daemon's folder: what they hold, their download, and a check by replay.
import type { Actions, Reader } from "../actions";
import { byId, make, setHidden, setText } from "../dom";
import { prefixed } from "../format";
import type { Recording } from "../protocol";
import { setPointWords } from "../results";
import { rowTime } from "./results";

const every = 4000;  // ms between two requests of the list while it is in view

const verdicts: Record<string, string> = {
    waiting: "… waiting", running: "… replaying", identical: "✓ identical", differs: "⚠ differs", failed: "⚠ failed",
};

export function setPointsWords(recording: Recording): string {
    const [first, ...more] = recording.set_points;
    if (first === undefined) return "";
    return more.length ? `${setPointWords(first)} and ${more.length} more` : setPointWords(first);
}

export function outcomeWords({ outcome, trouble }: Recording): string {
    return trouble !== null ? `⚠ not readable: ${trouble}` : outcome ?? "… not read yet";
}

/** A link that the browser follows by itself, so that a recording need not fit into the page's memory. */
function nameCell(recording: Recording, address: (path: string) => string): HTMLElement {
    const link = make("a", "", recording.name);
    link.href = address(`/api/recordings/${recording.name}`);
    link.download = recording.name;
    return link;
}

function checkCell(recording: Recording, check: (name: string) => void): Node {
    if (recording.replay === "waiting" || recording.replay === "running") return document.createTextNode(verdicts[recording.replay]!);
    const cell = make("span"), button = make("button", "link", recording.replay === null ? "replay" : "again");
    button.type = "button";
    button.setAttribute("aria-label", `Replay ${recording.name}`);
    button.addEventListener("click", () => check(recording.name));
    if (recording.replay !== null) cell.append(make("span", "", `${verdicts[recording.replay] ?? recording.replay} `));
    cell.title = recording.replay_text ?? "";
    cell.append(button);
    return cell;
}

function rowOf(recording: Recording, address: (path: string) => string, check: (name: string) => void): HTMLTableRowElement {
    const row = make("tr"), name = make("th");
    name.setAttribute("scope", "row");
    name.append(nameCell(recording, address));
    const checked = make("td");
    checked.append(recording.trouble === null ? checkCell(recording, check) : "");
    const texts = [
        rowTime(recording.started ?? recording.changed), prefixed(recording.bytes, "B"), setPointsWords(recording), outcomeWords(recording),
        recording.remarks.join("; "),
    ];
    row.append(name, ...texts.map((text) => make("td", text.length > 40 ? "text" : "", text)), checked);
    return row;
}

export function makeRecordings(act: Actions, reader: Reader): () => void {
    const body = byId("recordings-rows", HTMLTableSectionElement), count = byId("recordings-count", HTMLElement);
    const trouble = byId("recordings-trouble", HTMLElement), scroll = byId("recordings-scroll", HTMLElement);
    let due = 0, shown = "", asking = false;
    const say = (why: string): void => {
        setText(trouble, why);
        setHidden(trouble, why === "");
    };
    const check = (name: string): void => {
        void act(`recordings/${name}/replay`).then((answer) => {
            say(answer.ok ? "" : answer.error);
            due = 0;
        });
    };
    const show = (recordings: Recording[]): void => {
        const text = JSON.stringify(recordings);
        if (text === shown) return;
        shown = text;
        const bytes = recordings.reduce((sum, recording) => sum + recording.bytes, 0);
        setText(count, recordings.length ? `${recordings.length} recording${recordings.length === 1 ? "" : "s"}, ${prefixed(bytes, "B")} without pictures` : "No recording yet.");
        setHidden(scroll, recordings.length === 0);
        body.replaceChildren(...recordings.map((recording) => rowOf(recording, reader.address, check)));
    };
    return () => {
        if (asking || performance.now() < due) return;
        asking = true;
        due = performance.now() + every;
        void reader.json("/api/recordings").then((answer) => {
            asking = false;
            if (answer !== null) show((answer as { recordings: Recording[] }).recordings);
        });
    };
}
