#include "daemon/remote/web/live_socket.hpp"

#include <algorithm>
#include <optional>
#include <utility>

#include "daemon/catalogue/row_text.hpp"
#include "daemon/remote/access/server_clock.hpp"
#include "daemon/remote/web/live_frames.hpp"
#include "daemon/remote/web/site.hpp"
#include "daemon/remote/web/state_json.hpp"
#include "daemon/remote/web/subscription.hpp"

#include <boost/asio/co_spawn.hpp>
#include <boost/asio/detached.hpp>
#include <boost/asio/redirect_error.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <boost/beast/core/buffers_to_string.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/websocket.hpp>

namespace shaker::web {

namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
using asio::use_awaitable;
using Socket = beast::websocket::stream<beast::tcp_stream>;
using Clock = access::ServerClock;

constexpr std::chrono::milliseconds turn{33}, state_every{100};
constexpr std::chrono::seconds message_patience{10};  // for the client to receive one message

struct Stream {
    Subscription wish;
    Clock::time_point due{};
    std::uint64_t seen = 0;
    std::shared_ptr<const reduction::Reduction> shown{};
};

/// State of one socket, shared by its reader, its timer and its sender.
struct Live {
    Socket socket;
    std::shared_ptr<Site> site;
    std::string who;
    std::map<std::string, Stream> streams{};
    std::uint64_t sent_events = 0, answered = 0;  // number of events and orders already sent
    std::uint64_t sent_rows = 0;                  // number of the newest row of the results already sent
    // The result at which all points were last sent.
    std::optional<std::shared_ptr<const reduction::Reduction>> pointed{};
    Clock::time_point state_due{};
    run::RunState shown{};
    bool open = true;
    bool sending = false;
    bool aborting = false;      // the client waits for the answer to an abort
    std::string answer{};       // to its abort, if not empty
    Clock::time_point begun{};  // start of sending the present message
};

// New data of a stream as one message; empty: none.
std::string message_of(Stream& stream, Site& site, const service::BenchState& state) {
    const std::string& name = stream.wish.stream;
    service::LiveFeed& feed = site.pending_orders.bench_port().feed();
    const auto series = [&](const service::LiveSeries& s, StreamId id) -> std::string {
        const service::LiveSeries::Part part = s.since(stream.seen);
        if (part.t_s.empty()) return {};
        stream.seen = part.first + part.t_s.size();
        return frame_of(decimated(part, s.channels(), stream.wish.width, id));
    };
    if (name == "acceleration") return series(feed.acceleration, StreamId::acceleration);
    if (name == "track") return series(feed.track, StreamId::track);
    if (name == "waveform")
        return state.waveform.asked.empty() ? std::string{} : frame_of(waveform_of(state.waveform));
    if (name == "cycle") {
        if (!state.result || state.result == stream.shown) return {};
        stream.shown = state.result;
        return frame_of(cycle_of(*state.result));
    }
    for (std::size_t k = 0; k < state.pictures_now.size(); ++k)
        if (name == "camera:" + state.pictures_now[k].camera) return picture_frame(state.pictures_now[k], k);
    return {};
}

// Aborts that come before the answer to an earlier one are given; they have the same answer.
void abort(const std::shared_ptr<Live>& live) {
    const auto done = [live](const Answer& answer) {
        live->aborting = false;
        live->answer = R"({"type":"abort",)" + answer.json.substr(1);
    };
    live->site->actions.abort(live->who, live->aborting ? Actions::Done{} : done);
    live->aborting = true;
}

asio::awaitable<void> read(std::shared_ptr<Live> live) {
    beast::flat_buffer buffer;
    boost::system::error_code failed;
    while (!failed) {
        co_await live->socket.async_read(buffer, asio::redirect_error(use_awaitable, failed));
        if (failed) break;
        const std::string text = beast::buffers_to_string(buffer.data());
        if (is_abort(text)) abort(live);
        if (const auto wish = wish_of(text)) take(*wish, live->streams);
        buffer.consume(buffer.size());
    }
    live->open = false;
}

asio::awaitable<void> send(Live& live, bool text, const std::string& message) {
    live.begun = Clock::now();
    live.socket.text(text);
    co_await live.socket.async_write(asio::buffer(message), use_awaitable);
}

void set_next(Stream& stream, Clock::time_point now) {
    stream.due =
        now + std::chrono::milliseconds{static_cast<int>(1000 / stream.wish.rate_hz) - turn.count() / 2};
}

asio::awaitable<void> send_rows(Live& live) {
    catalogue::ResultsTable& results = live.site->pending_orders.bench_port().results();
    const std::uint64_t newest = results.newest();
    if (newest == live.sent_rows) co_return;
    const std::string text = results_json(results.since(live.sent_rows));
    live.sent_rows = newest;
    co_await send(live, true, text);
}

// Sends all messages that are due.
asio::awaitable<void> send_due(Live& live) {
    Site& site = *live.site;
    if (!live.answer.empty()) {
        const std::string answer = std::exchange(live.answer, {});
        co_await send(live, true, answer);
    }
    const auto state = site.pending_orders.now();
    for (const service::BenchEvent& e : site.pending_orders.bench_port().events(live.sent_events)) {
        live.sent_events = e.number;
        const std::string text = event_json(e, state ? state->now_s : e.t_s);
        co_await send(live, true, text);
    }
    co_await send_rows(live);
    const auto now = Clock::now();
    if (!state) co_return;
    if (now >= live.state_due || state->state != live.shown || state->answered != live.answered) {
        live.state_due = now + state_every - turn / 2;
        live.shown = state->state;
        live.answered = state->answered;
        const bool knows_points = live.pointed == state->result;
        live.pointed = state->result;
        const std::string owner = site.lock.owner();
        const auto text = site.state_texts.of(state, {owner, owner == live.who, knows_points, site.daemon});
        co_await send(live, true, *text);
    }
    for (auto it = live.streams.begin(); it != live.streams.end(); ++it) {
        Stream& stream = it->second;
        if (now < stream.due) continue;
        set_next(stream, now);
        const std::string message = message_of(stream, site, *state);
        const std::string name = it->first;
        if (!message.empty()) co_await send(live, false, message);
        it = live.streams.find(name);  // the reader may have ended it meanwhile
        if (it == live.streams.end()) break;
    }
}

asio::awaitable<void> write(std::shared_ptr<Live> live) {
    try {
        co_await send_due(*live);
    } catch (const std::exception&) {
        live->open = false;
    }
    live->sending = false;
}

// Skips messages that are due while the client has not received the previous one.
void drop_due(Live& live) {
    const auto now = Clock::now();
    if (now >= live.state_due) {
        live.state_due = now + state_every - turn / 2;
        ++live.site->served.messages_dropped;
    }
    for (auto& [name, stream] : live.streams) {
        if (now < stream.due) continue;
        set_next(stream, now);
        ++live.site->served.messages_dropped;
    }
}

// A slow client gets fewer messages: at most one waits here.
asio::awaitable<void> take_turns(std::shared_ptr<Live> live) {
    access::ServerTimer timer{live->socket.get_executor()};
    while (live->open) {
        if (!live->sending) {
            live->sending = true;
            asio::co_spawn(live->socket.get_executor(), write(live), asio::detached);
        } else if (Clock::now() - live->begun < message_patience) {
            drop_due(*live);
        } else {
            break;
        }
        timer.expires_after(turn);
        co_await timer.async_wait(use_awaitable);
    }
}

}  // namespace

asio::awaitable<void> live(beast::tcp_stream stream,
                           const beast::http::request<beast::http::string_body>& request,
                           std::shared_ptr<Site> site, const std::string& who) {
    auto shared = std::make_shared<Live>(Live{Socket{std::move(stream)}, site, who});
    set_limits(shared->socket);
    co_await shared->socket.async_accept(request, use_awaitable);
    ++site->sockets[who];
    asio::co_spawn(shared->socket.get_executor(), read(shared), asio::detached);
    co_await take_turns(shared);
    shared->open = false;
    if (--site->sockets[who] == 0) site->sockets.erase(who);
    beast::get_lowest_layer(shared->socket).close();
}

}  // namespace shaker::web
