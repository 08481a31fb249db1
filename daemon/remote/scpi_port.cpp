#include "daemon/remote/scpi_port.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <array>
#include <chrono>
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
}

ScpiPort::ScpiPort(service::PendingOrders& pending_orders, access::ControlLock& lock,
                   std::chrono::milliseconds silence)
    : lock_{lock},
      silence_{silence},
      instrument_{pending_orders,
                  [this](const scpi::Session& by) {
                      for (const auto& c : clients_)
                          if (&c->session != &by) c->session.drop_withheld();
                  },
                  [this](const std::string& session, const std::string& why) {
                      for (const auto& c : clients_)
                          if (c->session.name() == session)
                              c->session.report(scpi::Code::settings_conflict, why);
                  }},
      tree_{command_table(instrument_)} {}

asio::awaitable<void> ScpiPort::serve(asio::ip::tcp::socket socket) {
    if (clients_.size() >= most_sessions && !make_room()) co_return;
    std::shared_ptr<Client> client;
    try {
        const auto end = socket.remote_endpoint();
        client = std::make_shared<Client>(scpi::Shared{tree_, instrument_, status_, lock_},
                                          fmt::format("{}:{}", end.address().to_string(), end.port()),
                                          std::move(socket));
        clients_.push_back(client);
        co_await converse(client);
    } catch (const std::exception&) {  // a broken connection ends only itself
    }
    if (!client) co_return;
    count_errors(*client);
    clients_.remove(client);
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
        if ((*c)->heard > since || session.waiting() || lock_.owner() == session.name()) continue;
        if (longest == clients_.end() || (*c)->heard < (*longest)->heard) longest = c;
    }
    if (longest == clients_.end()) return false;
    boost::system::error_code ignored;
    (*longest)->socket.close(ignored);
    clients_.erase(longest);
    return true;
}

// Reads on while replies wait to be sent, because an ABORt may follow.
asio::awaitable<void> ScpiPort::converse(std::shared_ptr<Client> client) {
    std::array<char, 4096> bytes{};  // other clients have their turn after 4096 bytes
    boost::system::error_code failed;
    for (;;) {
        const std::size_t n = co_await client->socket.async_read_some(
            asio::buffer(bytes), asio::redirect_error(use_awaitable, failed));
        if (failed) break;
        client->heard = access::ServerClock::now();
        messages_ += static_cast<std::uint64_t>(
            std::count(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(n), '\n'));
        client->session.feed({bytes.data(), n});
        begin_flush(client);
    }
    client->session.finish();
    begin_flush(client);
    if (client->sending) {
        client->goodbye.expires_after(patience);
        co_await client->goodbye.async_wait(asio::redirect_error(use_awaitable, failed));
    }
    client->socket.close(failed);
}

void ScpiPort::begin_flush(const std::shared_ptr<Client>& client) {
    if (client->sending || client->session.output().empty()) return;
    client->sending = true;
    asio::co_spawn(client->socket.get_executor(), flush(client), asio::detached);
}

asio::awaitable<void> ScpiPort::flush(std::shared_ptr<Client> client) {
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
    const auto state = instrument_.pending_orders().now();
    if (!state) return;
    instrument::show(*state, status_);
    status_.set(scpi::Operation::waiting_trigger, instrument_.armed);
    if (state->trips > trips_ && state->trip)
        for (const auto& c : clients_) c->session.report(scpi::Code::abort, text(*state->trip));
    trips_ = state->trips;
    for (const auto& c : clients_) {
        c->session.poll();
        count_errors(*c);
        begin_flush(c);
    }
}

}  // namespace shaker::remote
