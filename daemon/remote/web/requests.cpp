#include "daemon/remote/web/requests.hpp"

#include <string_view>
#include <utility>

#include "daemon/catalogue/row_text.hpp"
#include "daemon/remote/web/live_frames.hpp"
#include "daemon/remote/web/order_fields.hpp"
#include "daemon/remote/web/state_json.hpp"
#include "daemon/run/state.hpp"
#include "drivers/errors.hpp"

#include <boost/beast/websocket/rfc6455.hpp>

namespace shaker::web {

namespace {

namespace beast = boost::beast;
namespace http = beast::http;

constexpr std::uint64_t most_body = 65536;  // bytes
constexpr std::uint32_t most_header = 8192;

std::string_view view(beast::string_view s) { return {s.data(), s.size()}; }

std::string path_of(const Request& request) {
    const std::string_view target = view(request.target());
    return std::string{target.substr(0, target.find('?'))};
}

// The value of `key` in a target such as "/ws?client=a1&token=b2".
std::string query_of(std::string_view target, std::string_view key) {
    auto at = target.find('?');
    while (at != std::string_view::npos) {
        const auto end = target.find('&', at + 1);
        const std::string_view part =
            target.substr(at + 1, end == std::string_view::npos ? end : end - at - 1);
        if (part.starts_with(key) && part.substr(key.size()).starts_with('='))
            return std::string{part.substr(key.size() + 1)};
        at = end;
    }
    return {};
}

// Properties of a request on which its reply depends.
struct Manner {
    unsigned version;
    bool keep_alive;
    MetricsFormat metrics;
};

Manner manner_of(const Request& request) {
    const bool open =
        view(request[http::field::accept]).find("application/openmetrics-text") != std::string_view::npos;
    return {request.version(), request.keep_alive(), open ? MetricsFormat::open : MetricsFormat::prometheus};
}

Response reply(Manner manner, int status, const std::string& type, std::string body) {
    Response r{static_cast<http::status>(status), manner.version};
    r.set(http::field::content_type, type);
    r.set(http::field::cache_control, "no-store");
    r.set("X-Content-Type-Options", "nosniff");
    r.set("Content-Security-Policy",
          "default-src 'self'; img-src 'self' blob: data:; frame-ancestors 'none'");
    r.keep_alive(manner.keep_alive);
    r.body() = std::move(body);
    r.prepare_payload();
    return r;
}

Response reply(Manner manner, const Answer& answer) {
    return reply(manner, answer.status, "application/json", answer.json);
}

Response plain(Manner manner, int status, const std::string& text) {
    return reply(manner, status, "text/plain; charset=utf-8", text + "\n");
}

std::vector<catalogue::NumberedRow> rows_of(Site& site) {
    return site.pending_orders.bench_port().results().since(0);
}

constexpr std::string_view recordings_path = "/api/recordings/", campaigns_path = "/api/campaigns/",
                           report_word = "/report", replay_word = "/replay",
                           trip_path = "/api/trip/pictures/";

// The picture of camera K at the trip: GET /api/trip/pictures/K, in the form of a live picture.
Response trip_picture(Manner manner, std::string_view number, const service::BenchState& state) {
    for (std::size_t k = 0; k < state.trip_pictures.size(); ++k)
        if (number == std::to_string(k))
            if (std::string bytes = picture_frame(state.trip_pictures[k], k); !bytes.empty())
                return reply(manner, 200, "application/octet-stream", std::move(bytes));
    return reply(manner, refusal(404, "there is no picture of a trip of this camera"));
}

Response law_curves(Manner manner, LawAnswer& law, const service::BenchState& state) {
    auto text = law.of(state);
    return text ? reply(manner, 200, "application/json", std::move(*text))
                : reply(manner, 202, "application/json", R"({"pending":true})");
}

// A refusal of what wanted_file() does not let through.
Response refused_download(Manner manner, const Site& site) {
    if (site.recordings == nullptr) return reply(manner, refusal(404, "no recordings are served"));
    if (site.downloads >= site.most_downloads)
        return reply(manner, refusal(503, "the limit of downloads is reached; wait for the end of one"));
    try {
        site.recordings->require_rest();
    } catch (const InputError& e) {
        return reply(manner, refusal(409, e.what()));
    }
    return reply(manner, refusal(404, "there is no such recording"));
}

// "/api/campaigns/NAME/report", "/api/recordings/NAME" + `word`.
std::optional<catalogue::WantedFile> file_of(const std::string& path, std::string_view word) {
    const bool report = path.starts_with(campaigns_path);
    const std::string_view front = report ? campaigns_path : recordings_path,
                           back = report ? report_word : word;
    if (!path.starts_with(front) || !path.ends_with(back) || path.size() <= front.size() + back.size())
        return std::nullopt;
    return catalogue::WantedFile{path.substr(front.size(), path.size() - front.size() - back.size()), report};
}

// POST /api/recordings/NAME/replay, /api/campaigns/NAME/report: checks a recording, makes a report.
Answer request_work(const std::string& path, const std::string& body, Site& site, const std::string& who) {
    const auto file = file_of(path, replay_word);
    if (site.recordings == nullptr || !file) return refusal(404, "not found: " + path);
    try {
        require_no_fields(body);
    } catch (const InputError& e) {
        return refusal(400, e.what());
    }
    if (!site.lock.allows(who)) return refusal(409, access::held_text(site.lock.owner()));
    try {
        site.recordings->request(*file);
        return {200, R"({"ok":true})"};
    } catch (const InputError& e) {
        return refusal(409, e.what());
    }
}

bool of_catalogue(const std::string& path) {
    return path.starts_with(recordings_path) || path.starts_with(campaigns_path);
}

Response answer_get(Manner manner, const std::string& path, Site& site, const std::string& who) {
    const auto state = site.pending_orders.now();
    if (const auto file = site.page.find(path); file != site.page.end())
        return reply(manner, 200, file->second.type, file->second.content);
    if (path == "/favicon.ico") return reply(manner, 204, "image/x-icon", "");
    if (path == "/metrics")
        return reply(manner, 200,
                     manner.metrics == MetricsFormat::open
                         ? "application/openmetrics-text; version=1.0.0; charset=utf-8"
                         : "text/plain; version=0.0.4; charset=utf-8",
                     metrics_text(state.get(), site.served, manner.metrics));
    if (path == "/healthz") {
        const bool well = state && state->state != run::RunState::tripped;
        return plain(manner, well ? 200 : 503, state ? name(state->state) : "starting");
    }
    if (path == "/readyz") {
        const bool ready = state && row_of(state->state).ready;
        return plain(manner, ready ? 200 : 503, ready ? "ready" : "starting");
    }
    if (path == "/api/state") {
        if (!state) return reply(manner, refusal(503, "the bench has not reported its state yet"));
        return reply(manner, 200, "application/json",
                     state_json(*state, {site.lock.owner(), site.lock.owner() == who, false, site.daemon}));
    }
    if (path == "/api/orders") return reply(manner, 200, "application/json", orders_json());
    if (path == "/api/result") {
        if (state && state->result) return reply(manner, 200, "application/json", result_json(*state));
        return reply(manner,
                     refusal(404, state && !state->not_reduced.empty() ? state->not_reduced
                                                                       : "no measurement is complete yet"));
    }
    if (path == "/api/law" && state) return law_curves(manner, site.law, *state);
    if (path.starts_with(trip_path) && state)
        return trip_picture(manner, std::string_view{path}.substr(trip_path.size()), *state);
    if (path == "/api/recordings" && site.recordings != nullptr)
        return reply(manner, 200, "application/json",
                     list_json(site.recordings->list(), site.recordings->campaigns()));
    if (of_catalogue(path)) return refused_download(manner, site);
    if (path == "/api/results") return reply(manner, 200, "application/json", results_json(rows_of(site)));
    if (path == "/api/repeats")
        return reply(manner, 200, "application/json", repeats_json(catalogue::repeats_of(rows_of(site))));
    if (path == "/api/results.csv")
        return reply(manner, 200, "text/csv; charset=utf-8", results_csv(rows_of(site)));
    return reply(manner, refusal(404, "not found: " + path));
}

bool token_right(const Request& request, const access::Access& access) {
    if (access.token_allowed(view(request["X-Shaker-Token"]))) return true;
    return access.token_allowed(query_of(view(request.target()), "token"));
}

// Anybody may abort, as over SCPI; only pages of other sites may not.
bool needs_token(const std::string& path) {
    return (path.starts_with("/api/") && path != "/api/abort") || path == "/ws" || path == "/metrics";
}

// The refusal of a request by the access rules; empty: it is accepted.
std::optional<Answer> refused(const Request& request, const access::Access& access) {
    const std::string_view host = view(request[http::field::host]);
    if (!access.host_allowed(host))
        return refusal(403, "unknown host name of this daemon: Host " + std::string{host.substr(0, 100)});
    if (!access.origin_allowed(view(request[http::field::origin]), host))
        return refusal(403, "requests from pages of other sites are refused");
    if (needs_token(path_of(request)) && !token_right(request, access))
        return refusal(401, "a token is required in the header X-Shaker-Token");
    return std::nullopt;
}

// A page names in a repeated abort the daemon for which it was pressed. Another one, started since, is at
// rest and leaves it alone; one that may drive obeys. An abort without a name always acts.
bool for_another(const Request& request, const Site& site) {
    const std::string_view daemon = view(request["X-Shaker-Daemon"]);
    return !daemon.empty() && daemon != site.daemon && site.pending_orders.bench_port().at_rest();
}

bool is_upgrade(const Request& request) {
    return beast::websocket::is_upgrade(request) && path_of(request) == "/ws";
}

}  // namespace

void set_limits(RequestParser& parser) {
    parser.body_limit(most_body);
    parser.header_limit(most_header);
}

std::string client_of(const Request& request, const std::string& address) {
    std::string client{view(request["X-Shaker-Client"])};
    if (client.empty()) client = query_of(view(request.target()), "client");
    std::string name = "page";
    for (const char c : client.substr(0, 12))
        if ((c >= '0' && c <= '9') || (c >= 'a' && c <= 'z')) {
            if (name.size() == 4) name += ' ';
            name += c;
        }
    return name + " at " + address;
}

std::optional<catalogue::WantedFile> wanted_file(const Request& request, const Site& site) {
    const auto file = file_of(path_of(request), {});
    if (request.method() != http::verb::get || !file || refused(request, site.access) ||
        site.recordings == nullptr || site.downloads >= site.most_downloads)
        return std::nullopt;
    try {
        site.recordings->require_rest();
    } catch (const InputError&) {
        return std::nullopt;
    }
    return catalogue::listed_name(file->report ? file->name + ".nxs" : file->name) ? file : std::nullopt;
}

bool takes_socket(const Request& request, const Site& site) {
    return is_upgrade(request) && !refused(request, site.access) && site.live_clients < site.most_live;
}

void answer(const Request& request, Site& site, const std::string& who,
            const std::function<void(Response)>& done) {
    const Manner manner = manner_of(request);
    const std::string path = path_of(request);
    const bool head = request.method() == http::verb::head;
    if (const auto why = refused(request, site.access)) return done(reply(manner, *why));
    if (is_upgrade(request))
        return done(reply(manner, refusal(503, "the limit of live sockets is reached; close one")));
    if (request.method() == http::verb::get || head) {
        Response response = answer_get(manner, path, site, who);
        if (head) response.body().clear();
        return done(std::move(response));
    }
    if (request.method() != http::verb::post || !path.starts_with("/api/"))
        return done(reply(manner, refusal(405, needs_token(path) ? "expected GET or POST" : "expected GET")));
    if (of_catalogue(path)) return done(reply(manner, request_work(path, request.body(), site, who)));
    if (path == "/api/abort" && for_another(request, site))
        return done(reply(manner, refusal(409,
                                          "the abort was for a daemon that has ended; this one was started "
                                          "since, is at rest and did nothing")));
    site.actions.act(path.substr(5), request.body(), who,
                     [manner, done](const Answer& a) { done(reply(manner, a)); });
}

Response unanswered(const Request& request) {
    return reply(
        manner_of(request),
        refusal(503, "the bench did not answer in time; the log shows whether the order was executed"));
}

}  // namespace shaker::web
