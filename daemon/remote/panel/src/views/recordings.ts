// Recordings and campaigns in the daemon's folder: what they hold, download, a check by replay, and reports.
import type { Actions, Reader } from "../actions";
import { byId, make, setHidden, setText } from "../dom";
import { prefixed } from "../format";
import type { CampaignFolder, Recording } from "../protocol";
import { setPointWords } from "../results";
import { rowTime } from "./results";

const every = 4000;  // ms between two requests of the list while it is in view

const verdicts: Record<string, string> = {
    waiting: "… waiting", running: "… at work", identical: "✓ identical", differs: "⚠ differs", failed: "⚠ failed",
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
    link.href = address(`api/recordings/${recording.name}`);
    link.download = recording.name;
    return link;
}

type Ask = (action: string) => void;

/** A button for work that the daemon does at idle priority, and how the last such work ended. */
function workCell(verdict: string | null, text: string | null, words: string, label: string, ask: () => void): Node {
    if (verdict === "waiting" || verdict === "running") return document.createTextNode(verdicts[verdict]!);
    const cell = make("span"), button = make("button", "link", verdict === null ? words : "again");
    button.type = "button";
    button.setAttribute("aria-label", label);
    button.addEventListener("click", ask);
    if (verdict !== null && verdict !== "made") cell.append(make("span", "", `${verdicts[verdict] ?? verdict} `));
    cell.title = text ?? "";
    cell.append(button);
    return cell;
}

function row(name: Node, texts: string[], work: Node | string): HTMLTableRowElement {
    const row = make("tr"), head = make("th"), last = make("td");
    head.setAttribute("scope", "row");
    head.append(name);
    last.append(work);
    row.append(head, ...texts.map((text) => make("td", text.length > 40 ? "text" : "", text)), last);
    return row;
}

function rowOf(recording: Recording, address: (path: string) => string, ask: Ask): HTMLTableRowElement {
    const { name, replay, replay_text } = recording;
    const work = recording.trouble === null ? workCell(replay, replay_text, "replay", `Replay ${name}`, () => ask(`recordings/${name}/replay`)) : "";
    return row(nameCell(recording, address), [
        rowTime(recording.started ?? recording.changed), prefixed(recording.bytes, "B"), setPointsWords(recording), outcomeWords(recording),
        recording.remarks.join("; "),
    ], work);
}

export function campaignRowOf(folder: CampaignFolder, address: (path: string) => string, ask: Ask): HTMLTableRowElement {
    const { name, report, report_text, recordings } = folder;
    const work = make("span");
    if (report === "made") {
        const link = make("a", "", "report");
        link.href = address(`api/campaigns/${name}/report`);
        link.target = "_blank";
        link.setAttribute("aria-label", `Report of ${name}`);
        work.append(link, " ");
    }
    if (folder.complete) work.append(workCell(report, report_text, "make the report", `Make the report of ${name}`, () => ask(`campaigns/${name}/report`)));
    return row(document.createTextNode(name), [
        rowTime(folder.changed), prefixed(folder.bytes, "B"), `campaign of ${recordings} recording${recordings === 1 ? "" : "s"}`,
        folder.complete ? "points table written" : "not ended", "",
    ], work);
}

export function makeRecordings(act: Actions, reader: Reader): () => void {
    const body = byId("recordings-rows", HTMLTableSectionElement), folders = byId("campaigns-rows", HTMLTableSectionElement), count = byId("recordings-count", HTMLElement);
    const trouble = byId("recordings-trouble", HTMLElement), scroll = byId("recordings-scroll", HTMLElement);
    let due = 0, shown = "", asking = false;
    const say = (why: string): void => {
        setText(trouble, why);
        setHidden(trouble, why === "");
    };
    const ask = (action: string): void => {
        void act(action).then((answer) => {
            say(answer.ok ? "" : answer.error);
            due = 0;
        });
    };
    const show = ({ recordings, campaigns }: { recordings: Recording[]; campaigns: CampaignFolder[] }): void => {
        const text = JSON.stringify([recordings, campaigns]);
        if (text === shown) return;
        shown = text;
        const bytes = recordings.reduce((sum, recording) => sum + recording.bytes, 0);
        setText(count, recordings.length ? `${recordings.length} recording${recordings.length === 1 ? "" : "s"}, ${prefixed(bytes, "B")} without pictures` : "No recording yet.");
        setHidden(scroll, recordings.length + campaigns.length === 0);
        folders.replaceChildren(...campaigns.map((folder) => campaignRowOf(folder, reader.address, ask)));
        body.replaceChildren(...recordings.map((recording) => rowOf(recording, reader.address, ask)));
    };
    return () => {
        if (asking || performance.now() < due) return;
        asking = true;
        due = performance.now() + every;
        void reader.json("api/recordings").then((answer) => {
            asking = false;
            if (answer !== null) show(answer as { recordings: Recording[]; campaigns: CampaignFolder[] });
        });
    };
}
