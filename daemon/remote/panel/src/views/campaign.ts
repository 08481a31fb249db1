// A campaign: the points of a plan, or of a scan, one after the other without a person.
import type { Actions, Reader } from "../actions";
import { byId, make, setHidden, setText } from "../dom";
import { duration } from "../format";
import type { Campaign, CampaignFolder, PlanCheck, State } from "../protocol";
import { typed, whole } from "../quantity";
import type { Store } from "../store";
import { watchForm, wire, type Refused } from "./form";

/** "measuring point 4 of 12: ...; about 3 min 10 s left". */
export function campaignWords(campaign: Campaign): string {
    const { points, ended, doing } = campaign;
    if (doing === "interrupted") return `interrupted: ${ended} of ${points} points have ended`;
    if (!campaign.active) return `ended: ${ended} of ${points} points; recordings and campaign.nxs are in ${campaign.folder}`;
    const words = [`${doing}: ${ended} of ${points} points have ended`];
    if (campaign.point) words.push(`now ${campaign.point}`);
    if (campaign.known_mu) words.push(campaign.known_mu);
    if (campaign.left_s !== null) words.push(`${campaign.known_mu ? "at most" : "about"} ${duration(campaign.left_s)} left`);
    return words.join("; ");
}

/** "Check of fig3: 24 points, 22 fit; bench time ...; point 3 does not fit: ...". */
export function checkWords(check: PlanCheck): string {
    const words = check.under_way ? ["under way"] : [check.summary, ...check.misfits];
    const more = check.points - check.fit - check.misfits.length;
    if (more > 0) words.push(`and ${more} more`);
    return `Check of ${check.plan}: ${words.join("; ")}`;
}

const scanUnits: Record<string, string> = { phi: "deg", gamma: "g" };
type ScanFields = Record<"from" | "to" | "steps" | "periods", string>;

/** The order for a scan, or why it is not one. A field without a unit is in degrees or g. `words`: what it scans. */
export function scanOrder(of: string, fields: ScanFields): { body: Record<string, unknown>; words: string } | Refused {
    const from = typed("from", fields.from, scanUnits[of]!), to = typed("to", fields.to, scanUnits[of]!);
    const steps = whole("steps", fields.steps, 1), periods = whole("periods", fields.periods, 3);
    if ("refused" in from) return from;
    if ("refused" in to) return to;
    if (typeof steps !== "number") return steps;
    if (typeof periods !== "number") return periods;
    return { body: { scan: of, from: from.text, to: to.text, steps, periods }, words: `${from.words} to ${to.words}` };
}

function input(id: string): HTMLInputElement { return byId(id, HTMLInputElement); }

function wireScan(act: Actions): void {
    const of = byId("scan-of", HTMLSelectElement), unit = byId("scan-unit", HTMLElement), scan = byId("scan", HTMLFormElement);
    const order = (): ReturnType<typeof scanOrder> => scanOrder(of.value, {
        from: input("scan-from").value, to: input("scan-to").value, steps: input("scan-steps").value, periods: input("scan-periods").value,
    });
    const show = watchForm(scan, () => {
        const asked = order();
        return "refused" in asked ? asked : `will be sent: ${asked.words}`;
    });
    of.addEventListener("change", () => {
        const phi = of.value === "phi";
        input("scan-from").value = phi ? "0" : "0.5";
        input("scan-to").value = phi ? "180" : "1.5";
        setText(unit, scanUnits[of.value]!);
        show();
    });
    wire(scan, act, () => {
        const asked = order();
        return "refused" in asked ? asked : asked.body;
    });
}

function showPlans(select: HTMLSelectElement, names: string[]): void {
    if (names.join() === [...select.options].map((option) => option.value).join()) return;
    const chosen = select.value;
    select.replaceChildren(...names.map((name) => { const option = make("option", "", name); option.value = name; return option; }));
    if (names.includes(chosen)) select.value = chosen;
}

const askedEvery = 2000;  // ms between two questions for a report under way

/** Has the report of a campaign made as soon as the list of recordings has the campaign, and shows the link to it. */
async function showReport(folder: string, act: Actions, reader: Reader): Promise<void> {
    const place = byId("campaign-report", HTMLElement);
    setText(place, "The report is being made…");
    for (let asked = false; ; await new Promise((resolve) => setTimeout(resolve, askedEvery))) {
        const answer = (await reader.json("api/recordings")) as { campaigns: CampaignFolder[] } | null;
        const found = answer?.campaigns.find(({ name }) => name === folder);
        if (!found) continue;
        asked ||= (await act(`campaigns/${folder}/report`)).ok;
        if (found.report === "failed") return setText(place, `⚠ The report was not made: ${found.report_text ?? ""}`);
        if (found.report !== "made") continue;
        const link = make("a", "", "Open the report");
        link.href = reader.address(`api/campaigns/${folder}/report`);
        link.target = "_blank";
        return place.replaceChildren(link);
    }
}

export function makeCampaign(act: Actions, reader: Reader, store: Store): () => void {
    const plans = byId("plans", HTMLSelectElement), words = byId("campaign-words", HTMLElement), newest = byId("campaign-newest", HTMLElement);
    const bar = byId("campaign-bar", HTMLProgressElement), starts = byId("campaign-start", HTMLElement), orders = byId("campaign-orders", HTMLElement);
    wire(byId("plan", HTMLFormElement), act, () => plans.value ? { plan: plans.value } : { refused: "plan: the folder of the plans has none" });
    wireScan(act);
    const pause = byId("campaign-pause", HTMLFormElement), resume = byId("campaign-resume", HTMLFormElement);
    wire(pause, act, () => ({}));
    wire(resume, act, () => ({}));
    let seen = -1, measured = "";  // folder of the campaign that this page saw under way
    const follow = (campaign: Campaign | null): void => {
        if (campaign?.active) measured = campaign.folder;
        if (!campaign || campaign.active || campaign.folder !== measured) return;
        measured = "";
        if (campaign.ended > 0) void showReport(campaign.folder, act, reader);
    };
    const check = byId("plan-check", HTMLElement);
    const show = ({ campaign, plan_check, plans: names }: State): void => {
        showPlans(plans, names);
        follow(campaign);
        const active = campaign?.active ?? false;
        setHidden(starts, active);
        setHidden(orders, !active);
        setHidden(bar, campaign === null);
        setText(words, campaign ? campaignWords(campaign) : "No campaign since the start of the daemon.");
        setText(newest, campaign?.newest ?? "");
        setText(check, plan_check && !active ? checkWords(plan_check) : "");
        setHidden(pause, campaign?.paused ?? false);
        setHidden(resume, !(campaign?.paused ?? false));
        if (campaign) {
            bar.max = Math.max(1, campaign.points);
            bar.value = campaign.ended;
        }
    };
    return () => {
        if (!store.state || seen === store.stateVersion) return;
        seen = store.stateVersion;
        show(store.state);
    };
}
