#include "daemon/remote/scpi_port.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <array>
#include <utility>
#include <boost/asio/buffer.hpp>
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/detached.hpp>
#include <boost/asio/redirect_error.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <boost/asio/write.hpp>

namespace shaker::remote {

namespace asio = boost::asio;
using asio::use_awaitable;

namespace {
constexpr std::chrono::seconds patience{5};  // time for a client that has closed to take its last replies
constexpr std::chrono::seconds late_patience{10};  // for the first message, when no session is free
constexpr std::string_view no_session =
    "-310,\"System error;16 sessions are open: close one. ABORt alone is obeyed on every connection\"\n";
}  // namespace

ScpiPort::ScpiPort(const Parts& parts, std::chrono::milliseconds silence)
    : parts_{parts},
      silence_{silence},
      instrument_{parts.pending_orders, parts.aborts,
                  [this](const std::string& session, const std::string& why) {
                      for (const auto& c : clients_)
                          if (c->session.name() == session)
                              c->session.report(scpi::Code::settings_conflict, why);
                  }},
      tree_{command_table(instrument_)} {}

void ScpiPort::drop_waiting(const std::string& aborted_by) {
    instrument_.armed = false;
    for (const auto& c : clients_)
        if (c->session.name() != aborted_by) c->session.drop_withheld();
}

asio::awaitable<void> ScpiPort::serve(Socket socket, std::string name, scpi::Admission admission) {
    const bool late = clients_.size() >= most_sessions && !make_room();
    ClientPtr client;
    try {
        client = std::make_shared<Client>(
            scpi::Shared{tree_, instrument_, status_, parts_.lock, parts_.access}, std::move(name),
            late ? scpi::Admission::abort_only : admission, std::move(socket));
        if (late && late_.size() >= most_late) send_away_longest();
        (late ? late_ : clients_).push_back(client);
        if (late)
            co_await hear_first_message(client);
        else
            co_await converse(client);
    } catch (const std::exception&) {  // a broken connection ends only itself
    }
    if (!client) co_return;
    count_errors(*client);
    client->goodbye.cancel();
    clients_.remove(client);
    late_.remove(client);
}

void ScpiPort::count_errors(Client& client) noexcept {
    const std::uint64_t reported = client.session.reported();
    errors_ += reported - std::exchange(client.counted, reported);
}

bool ScpiPort::make_room() {
    const auto since = access::ServerClock::now() - silence_;
    auto longest = clients_.end();
    for (auto c = clients_.begin(); c != clients_.end(); ++c) {
        const scpi::Session& session = (*c)->session;
        if ((*c)->heard > since || session.waiting() || parts_.lock.owner() == session.name()) continue;
        if (longest == clients_.end() || (*c)->heard < (*longest)->heard) longest = c;
    }
    if (longest == clients_.end()) return false;
    boost::system::error_code ignored;
    (*longest)->socket.close(ignored);
    clients_.erase(longest);
    return true;
}

void ScpiPort::hear(Client& client, std::string_view bytes) {
    client.heard = access::ServerClock::now();
    messages_ += static_cast<std::uint64_t>(std::ranges::count(bytes, '\n'));
    client.session.feed(bytes);
    const std::string_view why = client.session.ended();
    if (why.empty()) return;
    service::BenchPort& port = parts_.pending_orders.bench_port();
    const auto now = port.state();
    port.log(now ? now->now_s : 0, "warning",
             fmt::format("SCPI connection of {} was closed: {}", client.session.name(), why),
             fmt::format("SCPI connection closed: {}", why));
}

// Reads on while replies wait to be sent, because an ABORt may follow.
asio::awaitable<void> ScpiPort::converse(ClientPtr client) {
    std::array<char, 4096> bytes{};  // other clients have their turn after 4096 bytes
    boost::system::error_code failed;
    while (client->session.ended().empty()) {
        const std::size_t n = co_await client->socket.async_read_some(
            asio::buffer(bytes), asio::redirect_error(use_awaitable, failed));
        if (failed) break;
        hear(*client, {bytes.data(), n});
        begin_flush(client);
    }
    client->session.finish();
    begin_flush(client);
    if (client->sending && client->session.ended().empty()) {
        client->goodbye.expires_after(patience);
        co_await client->goodbye.async_wait(asio::redirect_error(use_awaitable, failed));
    }
    client->socket.close(failed);
}

// The timer ends the wait for a message and for its answer, and the sending.
asio::awaitable<void> ScpiPort::hear_first_message(ClientPtr client) {
    client->goodbye.expires_after(late_patience);
    client->goodbye.async_wait([client](boost::system::error_code cancelled) {
        boost::system::error_code ignored;
        if (!cancelled) client->socket.close(ignored);
    });
    std::array<char, 512> bytes{};
    const scpi::Session& session = client->session;
    for (std::size_t most = 4096; most > 0 && session.messages() == 0 && session.ended().empty();) {
        const std::size_t n = co_await client->socket.async_read_some(
            asio::buffer(bytes.data(), std::min(bytes.size(), most)), use_awaitable);
        most -= n;
        hear(*client, {bytes.data(), n});
    }
    access::ServerTimer turn{client->socket.get_executor()};
    while (session.aborting()) {
        turn.expires_after(std::chrono::milliseconds{5});
        co_await turn.async_wait(use_awaitable);
        client->session.poll();
    }
    std::string answer;
    if (session.ended().empty()) {
        answer = session.output();
        if (session.abort_failed())
            answer += fmt::format("{},\"{}\"\n", static_cast<int>(scpi::Code::output_silent),
                                  access::Aborts::silent_text);
        answer += no_session;
    }
    co_await asio::async_write(client->socket, asio::buffer(answer), use_awaitable);
    client->goodbye.cancel();
    boost::system::error_code ignored;
    client->socket.close(ignored);
}

// Its message may have arrived already.
void ScpiPort::send_away_longest() {
    const ClientPtr client = late_.front();
    late_.pop_front();
    boost::system::error_code failed;
    std::array<char, 512> bytes{};
    const std::size_t ready = client->socket.available(failed);
    if (!failed && ready > 0) {
        const std::size_t n = client->socket.read_some(asio::buffer(bytes), failed);
        if (!failed) hear(*client, {bytes.data(), n});
    }
    client->socket.close(failed);
}

void ScpiPort::begin_flush(const ClientPtr& client) {
    if (client->sending || client->session.output().empty()) return;
    client->sending = true;
    asio::co_spawn(client->socket.get_executor(), flush(client), asio::detached);
}

asio::awaitable<void> ScpiPort::flush(ClientPtr client) {
    boost::system::error_code failed;
    while (!failed && !client->session.output().empty()) {
        // A copy: commands that are executed meanwhile append to output().
        const std::string piece{client->session.output()};
        const std::size_t n = co_await asio::async_write(client->socket, asio::buffer(piece),
                                                         asio::redirect_error(use_awaitable, failed));
        client->session.sent(n);
    }
    client->sending = false;
    client->goodbye.cancel();
}

void ScpiPort::update() {
    if (const auto state = parts_.pending_orders.now()) {
        instrument::show(*state, status_);
        status_.set(scpi::Operation::waiting_trigger, instrument_.armed);
        if (state->trips > trips_ && state->trip)
            for (const auto& c : clients_) c->session.report(scpi::Code::abort, text(*state->trip));
        trips_ = state->trips;
    }
    for (const auto& c : clients_) {
        c->session.poll();
        count_errors(*c);
        begin_flush(c);
    }
}

}  // namespace shaker::remote
