// Replies and errors of the instrument language, to the byte.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>

#include "daemon/remote/instrument/instrument.hpp"
#include "daemon/remote/scpi/session.hpp"
#include "tests/fuzz/inline_bench.hpp"
#include "tests/support/golden.hpp"

namespace shaker::scpi {
namespace {

/// One client of a bench that executes orders without devices.
class Door {
public:
    /// "> message", the replies, and each error behind "! ".
    std::string told(const std::string& message) {
        std::string all = "> " + message + '\n' + answer(message);
        for (;;) {
            const std::string error = answer("SYST:ERR?");
            if (error.starts_with("0,")) return all;
            all += "! " + error;
            if (!client_.ended().empty())
                return all + "the connection is closed: " + std::string{client_.ended()} + '\n';
        }
    }
    [[nodiscard]] const CommandTree& commands() const noexcept { return tree_; }

private:
    std::string answer(const std::string& message) {
        client_.feed(message + '\n');
        for (int turns = 0; turns == 0 || (client_.waiting() && turns < 1000); ++turns) {
            bench_.settle();
            instrument::show(*bench_.pending_orders.now(), status_);
            client_.poll();
        }
        std::string replies{client_.output()};
        client_.sent(replies.size());
        return replies;
    }

    test::InlineBench bench_;
    instrument::BenchInstrument instrument_{bench_.pending_orders, bench_.aborts,
                                            [this](const std::string& /*session*/, const std::string& why) {
                                                client_.report(Code::settings_conflict, why);
                                            }};
    CommandTree tree_{command_table(instrument_)};
    DeviceStatus status_;
    access::Access access_{};
    Session client_{{tree_, instrument_, status_, bench_.lock, access_}, "client"};
};

/// ":SOURce:HARMonic1:AMPLitude" for "[SOURce:]HARMonic<1..16>:AMPLitude".
std::string header_of(const Command& command) {
    std::string header;
    for (std::size_t i = 0; i < command.header.size(); ++i) {
        const char c = command.header[i];
        if (c == '[' || c == ']' || c == '<') continue;
        if (c == '.') i = command.header.find('>', i);
        if (c != '.') header += c;
    }
    return header.starts_with('*') || header.starts_with(':') ? header : ':' + header;
}

/// A value that the parameter allows, and one that it does not.
std::pair<std::string, std::string> values_of(const Parameter& p) {
    if (p.numeric()) return {std::isfinite(p.standard) ? "DEF" : std::isfinite(p.min) ? "MIN" : "1", "1E99"};
    if (p.kind == Kind::boolean) return {"ON", "PERHAPS"};
    if (p.kind == Kind::choice) return {p.words.front().short_form, "NONSENSE"};
    if (p.kind == Kind::string) return {"'walk'", "7"};
    return {"#14walk", "'walk'"};
}

std::string listed(const std::vector<Parameter>& parameters, bool allowed) {
    std::string all;
    for (const Parameter& p : parameters) {
        const auto [good, bad] = values_of(p);
        all += (all.empty() ? " " : ",") + (allowed ? good : bad);
    }
    return all;
}

TEST(GoldenScpiTest, EveryCommandOfTheTable) {
    std::string all;
    const auto count = Door{}.commands().commands().size();
    for (std::size_t i = 0; i < count; ++i) {
        Door door;
        const Command& command = door.commands().commands()[i];
        const std::string header = header_of(command);
        all += "\n# " + command.header + '\n';
        if (command.query) all += door.told(header + '?' + listed(command.query_parameters, true));
        if (command.query && !command.query_parameters.empty())
            all += door.told(header + '?' + listed(command.query_parameters, false));
        if (!command.set) continue;
        all += door.told(header + listed(command.parameters, true));
        if (command.query) all += door.told(header + '?');
        if (!command.parameters.empty())
            all += door.told(header) + door.told(header + listed(command.parameters, false));
        if (command.query && command.parameters.size() == 1 && command.parameters.front().numeric())
            all += door.told(header + "? MIN") + door.told(header + "? MAX") + door.told(header + "? DEF");
    }
    test::expect_golden("scpi/commands.txt", test::without_place_and_time(all));
}

// The lines "> message" of the kept text are sent; a line "# title" begins with a bench of its own.
TEST(GoldenScpiTest, DialoguesWithErrors) {
    std::string all;
    std::optional<Door> door;
    for (const std::string& line : test::golden_inputs("scpi/dialogues.txt", {"# ", "> "})) {
        if (line.starts_with("# ")) {
            door.emplace();
            all += line + '\n';
        } else if (door)
            all += door->told(line.substr(2));
    }
    test::expect_golden("scpi/dialogues.txt", test::without_place_and_time(all));
}

}  // namespace
}  // namespace shaker::scpi
