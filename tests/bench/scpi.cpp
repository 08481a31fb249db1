// Cost and heap use of one SCPI command, by the number of commands in the table.
#include <array>
#include <cctype>
#include <string>
#include <string_view>
#include <vector>

#include "daemon/remote/scpi/session.hpp"
#include "daemon/remote/scpi/standard_commands.hpp"
#include "tests/bench/table.hpp"
#include "tests/support/cost.hpp"
#include "tests/support/no_alloc.hpp"
#include "tests/support/remote/scpi_client.hpp"

namespace shaker {
namespace {

constexpr int repeats = 21;
constexpr int messages = 2000;
const std::string conditions = "each command of the table in turn, long and short forms, median of 21 x 2000";

/// Three mnemonics, about ten commands per group: "SOURce:BCRoup:ABLevel".
std::string header(int i) {
    const auto letter = [](int place) { return static_cast<char>('A' + place % 26); };
    const int group = i / 10;
    constexpr std::array subsystems{"SOURce", "SENSe", "CONTrol", "LIMit", "STATus", "SYSTem"};
    std::string text{subsystems.at(static_cast<std::size_t>(group) % subsystems.size())};
    text += {':', letter(group), letter(group / 26), 'G', 'r', 'o', 'u', 'p'};
    return text + std::string{':', letter(i % 10), 'L', 'E', 'V', 'e', 'l'};
}

struct Workload {
    std::vector<std::string> headers;
    std::vector<std::string> lines;  // "HEADer:IN:FULL 1.5E1 HZ", without line feeds
};

std::string short_form(const std::string& text) {
    std::string out;
    for (const char c : text)
        if (std::islower(static_cast<unsigned char>(c)) == 0) out += c;
    return out;
}

Workload workload(int commands) {
    Workload work;
    for (int i = 0; i < commands; ++i) work.headers.push_back(header(i));
    for (int i = 0; i < messages; ++i) {
        const std::string& text = work.headers[static_cast<std::size_t>(i * 7 % commands)];
        work.lines.push_back((i % 2 == 0 ? text : short_form(text)) + " 1.5E1 HZ");
    }
    return work;
}

/// Simple reference: compares the pattern of each row with the header until one matches.
class LinearScan {
public:
    explicit LinearScan(const Workload& work) : headers_{work.headers} {}

    [[nodiscard]] int find(std::string_view line) const {
        const std::string_view text = line.substr(0, line.find(' '));
        for (std::size_t i = 0; i < headers_.size(); ++i)
            if (fits(headers_[i], text)) return static_cast<int>(i);
        return -1;
    }

private:
    static bool fits(std::string_view pattern, std::string_view text) {
        for (;;) {
            const std::string_view word = pattern.substr(0, pattern.find(':'));
            const std::string_view said = text.substr(0, text.find(':'));
            std::size_t brief = 0;
            while (brief < word.size() && std::islower(static_cast<unsigned char>(word[brief])) == 0) ++brief;
            if (said.size() != word.size() && said.size() != brief) return false;
            for (std::size_t i = 0; i < said.size(); ++i)
                if (std::toupper(static_cast<unsigned char>(said[i])) !=
                    std::toupper(static_cast<unsigned char>(word[i])))
                    return false;
            if (word.size() == pattern.size() || said.size() == text.size())
                return word.size() == pattern.size() && said.size() == text.size();
            pattern.remove_prefix(word.size() + 1);
            text.remove_prefix(said.size() + 1);
        }
    }
    std::vector<std::string> headers_;
};

struct Cost {
    double ns = 0;
    double allocations = 0;
};

/// Cost of one message.
template <class Work>
Cost cost_of(Work work) {
    Cost cost;
    cost.ns = bench::median_cost_ns(repeats, work) / messages;
    const test::HeapCalls before = test::heap_calls();
    work();
    cost.allocations = static_cast<double>(test::heap_calls().taken - before.taken) / messages;
    return cost;
}

void add(bench::Table& table, const std::string& method, int commands, Cost cost, double wrong) {
    table.add({{"method", method},
               {"commands in the table", static_cast<double>(commands), "", 4},
               {"cost", cost.ns, "ns a command"},
               {"allocations", cost.allocations, "a command"},
               {"not understood", wrong},
               {"conditions", conditions}});
}

void add_rows(bench::Table& table, int commands) {
    const Workload work = workload(commands);
    test::ScpiBench parts;  // its instrument, status and lock
    double sum = 0;
    std::vector<scpi::Command> rows;
    for (const std::string& text : work.headers)
        rows.push_back({.header = text,
                        .parameters = {scpi::number("HZ", 1, 200)},
                        .set = [&](scpi::Call& call) { sum += call.arguments[0].number; },
                        .query = [](scpi::Call& call) { call.reply.number(15); }});
    const scpi::CommandTree tree{std::move(rows)};
    scpi::Session session{{tree, parts.instrument, parts.status, parts.lock, parts.access}, "bench"};
    const auto wrong = [&] { return static_cast<double>(session.status().errors.size()); };

    std::size_t found = 0;
    const Cost header_only = cost_of([&] {
        for (const std::string& line : work.lines) {
            std::array<char, 64> copy{};
            scpi::Text text{copy.data(), copy.data() + line.copy(copy.data(), copy.size())};
            scpi::Path path;
            found += tree.find(text, path).command != nullptr ? 1U : 0U;
        }
    });
    add(table, "shakerd, header", commands, header_only,
        static_cast<double>((repeats + 2) * messages) - static_cast<double>(found));
    add(table, "shakerd, message with a number and its unit", commands, cost_of([&] {
            for (const std::string& line : work.lines) {
                session.feed(line);
                session.feed("\n");
            }
        }),
        wrong());
    std::vector<std::string> queries;
    for (const std::string& line : work.lines) queries.push_back(line.substr(0, line.find(' ')) + "?\n");
    add(table, "shakerd, query and its reply", commands, cost_of([&] {
            for (const std::string& query : queries) {
                session.feed(query);
                session.sent(session.output().size());
            }
        }),
        wrong());
    const LinearScan scan{work};
    double missed = 0;
    const Cost linear = cost_of([&] {
        for (const std::string& line : work.lines) missed += scan.find(line) < 0 ? 1 : 0;
    });
    add(table, "linear scan, header", commands, linear, missed);
}

}  // namespace
}  // namespace shaker

int main(int argc, char** argv) {
    using namespace shaker;
    bench::Table table;
    for (const int commands : {10, 50, 200, 1000}) add_rows(table, commands);
    table.print(argc, argv);
}
