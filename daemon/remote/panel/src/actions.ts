// HTTP actions. They do not use the socket, so an abort needs only one successful request.

export type Answer = { ok: true } | { ok: false; error: string };
export type Actions = (name: string, body?: Record<string, unknown>, patience?: number) => Promise<Answer>;

const tokenKey = "shakerd-token", clientKey = "shakerd-client";

/** Name of this tab, by which the daemon knows the holder of control; kept over reloads. */
export function clientName(): string {
    const known = sessionStorage.getItem(clientKey);
    if (known) return known;
    const made = Array.from(crypto.getRandomValues(new Uint8Array(6)), (byte) => (byte % 36).toString(36)).join("");
    sessionStorage.setItem(clientKey, made);
    return made;
}

/** The token of `#token=...`, removed from the address bar and kept for reloads of this tab. */
export function takeToken(): string | null {
    const given = new URLSearchParams(location.hash.slice(1)).get("token");
    if (given) {
        sessionStorage.setItem(tokenKey, given);
        history.replaceState(null, "", location.pathname + location.search);
    }
    return sessionStorage.getItem(tokenKey);
}

async function errorOf(response: Response): Promise<string> {
    const body = (await response.json().catch(() => null)) as { error?: unknown } | null;
    return typeof body?.error === "string" ? body.error : `the daemon answered ${response.status}`;
}

export function makeActions(token: string | null, client: string): Actions {
    const headers: Record<string, string> = { "Content-Type": "application/json", "X-Shaker-Client": client };
    if (token) headers["X-Shaker-Token"] = token;
    return async (name, body, patience = 10_000) => {
        const limit = new AbortController();
        const timer = setTimeout(() => limit.abort(), patience);  // ms
        try {
            const response = await fetch(`/api/${name}`, {
                method: "POST",
                headers,
                body: body ? JSON.stringify(body) : null,
                signal: limit.signal,
                keepalive: true,  // an abort is sent even when the page is closed directly after it
            });
            return response.ok ? { ok: true } : { ok: false, error: await errorOf(response) };
        } catch {
            return { ok: false, error: "no answer from the daemon" };
        } finally {
            clearTimeout(timer);
        }
    };
}
