// One client of the instrument language, with the bench's commands behind it.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "daemon/remote/instrument/instrument.hpp"
#include "daemon/remote/scpi/session.hpp"
#include "tests/fuzz/inline_bench.hpp"

namespace {

using namespace shaker;
using test::require;

// Created again for each input. The table of commands is created only once, because that takes long; its
// commands refer to this object.
std::optional<instrument::BenchInstrument>& the_instrument() {
    static std::optional<instrument::BenchInstrument> instrument;
    return instrument;
}

const scpi::CommandTree& commands() {
    static const scpi::CommandTree tree{command_table(*the_instrument())};
    return tree;
}

struct Door {
    Door() {
        the_instrument().emplace(bench.pending_orders, bench.aborts,
                                 [this](const std::string& session, const std::string& why) {
                                     if (client != nullptr && client->name() == session)
                                         client->report(scpi::Code::settings_conflict, why);
                                 });
        bench.aborts.after([](const std::string&) { the_instrument()->armed = false; });
    }
    [[nodiscard]] scpi::Shared shared() {
        return {commands(), *the_instrument(), status, bench.lock, access};
    }
    void go_on() {
        bench.settle();
        instrument::show(*bench.pending_orders.now(), status);
        client->poll();
    }

    test::InlineBench bench;
    scpi::DeviceStatus status;
    access::Access access{};
    scpi::Session* client = nullptr;
};

void check_output(const scpi::Session& client, std::size_t before) {
    const std::string_view output = client.output();
    require(output.empty() || output.back() == '\n', "a reply ends in LF");
    require(output.size() >= before, "replies that were not sent stay");
    require(output.size() <= scpi::Session::output_limit, "replies stay within their limit");
}

std::string ask(Door& door, scpi::Session& client, std::string_view message) {
    client.sent(client.output().size());
    client.feed(message);
    door.go_on();
    return std::string{client.output()};
}

// Independent of the daemon's own rule: a request line of HTTP with one of the methods of a browser.
bool is_request(std::string_view bytes) {
    const std::string_view line = bytes.substr(0, bytes.find("\r\n"));
    if (line.size() == bytes.size() || !line.ends_with(" HTTP/1.1")) return false;
    for (const std::string_view method : {"GET /", "HEAD /", "POST /", "OPTIONS /"})
        if (line.starts_with(method)) return line.find('\n') == std::string_view::npos;
    return false;
}

}  // namespace

// Bits of the first byte: length of the pieces; the bench executes orders in between; another client has
// control.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    if (size == 0) return 0;
    const std::size_t piece = 1U + (data[0] & 0x3fU);
    const bool prompt = (data[0] & 0x80U) != 0, held = (data[0] & 0x40U) != 0;
    Door door;
    scpi::Session client{door.shared(), "client"};
    door.client = &client;
    if (held) door.bench.lock.request("somebody else");
    std::string_view rest{reinterpret_cast<const char*>(data) + 1, size - 1};
    const bool from_browser = is_request(rest);
    while (!rest.empty()) {
        const std::size_t before = client.output().size();
        client.feed(rest.substr(0, piece));
        rest.remove_prefix(std::min(piece, rest.size()));
        if (prompt) door.go_on();
        check_output(client, before);
    }
    constexpr std::size_t measured_in = 2 * test::PlayedPort::shown_each;  // turns, at most
    for (std::size_t turns = 0; turns == 0 || client.waiting(); ++turns) {
        require(turns <= measured_in * size, "what waits ends");
        door.go_on();
    }
    client.finish();
    check_output(client, 0);
    if (from_browser) {
        require(!client.ended().empty(), "a browser's connection is closed");
        require(door.bench.played.ordered().empty() && door.bench.played.aborts == 0, "a page is not obeyed");
    }
    if (held) {
        require(door.bench.lock.owner() == "somebody else", "control stays where it is");
        require(door.bench.played.ordered().empty(), "only the holder of control is obeyed");
    }
    if (!client.ended().empty()) return 0;
    require(ask(door, client, "*CLS\nSYST:ERR?\n") == "0,\"No error\"\n", "*CLS empties the queue of errors");

    const int aborts = door.bench.played.aborts;
    scpi::Session other{door.shared(), "other"};
    other.feed("ABOR\n");
    require(door.bench.played.aborts == aborts + 1, "an abort of another client reaches the bench");
    return 0;
}
