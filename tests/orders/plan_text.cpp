#include "tests/orders/plan_text.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <charconv>
#include <fstream>
#include <iterator>
#include <optional>
#include <sstream>
#include <utility>

#include "drivers/errors.hpp"

namespace shaker::orders {

namespace {

constexpr double longest_s = 3600;   // of a plan
constexpr double highest_hz = 1000;  // frequency of a drive
constexpr double longest_buffer_s = 1, longest_enable_s = 5;

/// The words of one line, read from left to right.
class Line {
public:
    Line(std::size_t number, const std::string& text) : number_{number}, words_{text} {}

    std::string first() {
        std::string word;
        words_ >> word;
        return word;
    }

    /// The text after `key=` in the next word.
    std::string value(const std::string& key, const std::string& expected) {
        std::string word;
        words_ >> word;
        if (!word.starts_with(key + "=")) refuse(word, fmt::format("{}={}", key, expected));
        return word.substr(key.size() + 1);
    }

    template <class Number>
    Number number(const std::string& key, Number least, Number most) {
        const std::string expected = fmt::format("a number from {} to {}", least, most);
        const std::string given = value(key, expected);
        Number read{};
        const auto [end, error] = std::from_chars(given.data(), given.data() + given.size(), read);
        // NaN is in no range.
        if (error != std::errc{} || end != given.data() + given.size() || !(read >= least && read <= most))
            refuse(key + "=" + given, expected);
        return read;
    }

    /// The index of the value in a list of names.
    template <class Names>
    std::size_t index(const std::string& key, const Names& names) {
        const std::string expected = fmt::format("one of {}", fmt::join(names, ", "));
        const std::string given = value(key, expected);
        const auto found = std::ranges::find(names, given);
        if (found == names.end()) refuse(key + "=" + given, expected);
        return static_cast<std::size_t>(found - names.begin());
    }

    /// Whether the next word begins with `word`; a word without a value is taken.
    bool next_is(const std::string& word) {
        const auto here = words_.tellg();
        std::string next;
        if (words_ >> next && next == word) return true;
        words_.clear();
        words_.seekg(here);
        return next.starts_with(word + "=");
    }

    void end() {
        if (std::string word; words_ >> word) refuse(word, "the end of the line");
    }

    [[noreturn]] void refuse(const std::string& given, const std::string& expected) const {
        throw InputError{fmt::format("line {}: '{}': expected {}", number_,
                                     given.empty() ? "end of the line" : given, expected)};
    }

private:
    std::size_t number_;
    std::istringstream words_;
};

constexpr std::array yes_or_no{"no", "yes"};

std::vector<std::string> trouble_names() {
    std::vector<std::string> names;
    for (std::size_t i = 0; i < troubles; ++i) names.emplace_back(name_of_trouble(i));
    return names;
}

Plan read_head(Line& line) {
    Plan plan;
    plan.seed = line.number<std::uint64_t>("seed", 0, UINT64_MAX);
    plan.length_s = line.number<double>("length_s", 0, longest_s);
    plan.frequency_hz = line.number<double>("frequency_hz", 1, highest_hz);
    plan.identifies = line.index("identifies", yes_or_no) == 1;
    plan.buffer_s = line.number<double>("buffer_s", 0, longest_buffer_s);
    plan.kept_s = line.number<double>("kept_s", 0, plan.buffer_s);
    plan.at_edge = line.next_is("at_edge");
    if (line.next_is("enable_s")) plan.enable_s = line.number<double>("enable_s", 0, longest_enable_s);
    line.end();
    return plan;
}

Move read_move(Line& line, double least_s) {
    Move move;
    move.at_s = line.number<double>("at_s", least_s, longest_s);
    move.client = line.number<int>("client", 0, 2);
    move.action = static_cast<Action>(line.index("action", action_names));
    move.value = line.number<double>("value", 0, 1);
    return move;
}

Fault read_fault(Line& line, double least_s) {
    Fault fault;
    fault.at_s = line.number<double>("at_s", least_s, longest_s);
    fault.trouble = line.index("what", trouble_names());
    fault.for_s = line.number<double>("for_s", 0, longest_s);
    fault.value = line.number<double>("value", 0, 1);
    return fault;
}

}  // namespace

std::string text(const Plan& plan) {
    std::vector<std::pair<double, std::string>> lines;
    for (const Move& m : plan.moves)
        lines.emplace_back(m.at_s,
                           fmt::format("move at_s={} client={} action={} value={}\n", m.at_s, m.client,
                                       action_names.at(static_cast<std::size_t>(m.action)), m.value));
    for (const Fault& f : plan.faults)
        lines.emplace_back(f.at_s, fmt::format("fault at_s={} what={} for_s={} value={}\n", f.at_s,
                                               name_of_trouble(f.trouble), f.for_s, f.value));
    std::ranges::stable_sort(lines, {}, &std::pair<double, std::string>::first);
    std::string all = fmt::format(
        "plan seed={} length_s={} frequency_hz={} identifies={} buffer_s={} kept_s={}{}\n", plan.seed,
        plan.length_s, plan.frequency_hz, yes_or_no.at(plan.identifies ? 1 : 0), plan.buffer_s, plan.kept_s,
        (plan.at_edge ? " at_edge" : "") +
            (plan.enable_s > 0 ? fmt::format(" enable_s={}", plan.enable_s) : ""));
    for (const auto& [at_s, line] : lines) all += line;
    return all;
}

Plan plan_from_text(const std::string& text) {
    std::optional<Plan> plan;
    double last_s = 0;
    std::istringstream in{text};
    std::size_t number = 0;
    for (std::string words; std::getline(in, words);) {
        Line line{++number, words};
        const std::string kind = line.first();
        if (kind.empty() || kind.starts_with('#')) continue;
        if (!plan) {
            if (kind != "plan") line.refuse(kind, "plan, as the first word that is not in a comment");
            plan = read_head(line);
        } else if (kind == "move") {
            plan->moves.push_back(read_move(line, last_s));
            last_s = plan->moves.back().at_s;
        } else if (kind == "fault") {
            plan->faults.push_back(read_fault(line, last_s));
            last_s = plan->faults.back().at_s;
        } else {
            line.refuse(kind, "move or fault");
        }
        line.end();
    }
    if (!plan) throw InputError{"the text has no line that begins with plan"};
    return *plan;
}

Plan read_plan(const std::filesystem::path& file) try {
    std::ifstream in{file};
    if (!in) throw InputError{"cannot be read"};
    return plan_from_text({std::istreambuf_iterator<char>{in}, {}});
} catch (const InputError& e) {
    throw InputError{fmt::format("{}: {}", file.string(), e.what())};
}

void write_plan(const std::filesystem::path& file, const Plan& plan, const Violation& why) {
    if (file.has_parent_path()) std::filesystem::create_directories(file.parent_path());
    std::string comment = text(why);
    std::ranges::replace(comment, '\n', ' ');  // a comment ends with its line
    std::ofstream out{file};
    out << "# " << comment << '\n' << text(plan);
    if (!out.flush()) throw InputError{fmt::format("{}: cannot be written", file.string())};
}

std::vector<std::filesystem::path> plans_in(const std::filesystem::path& folder) {
    std::vector<std::filesystem::path> files;
    for (const auto& entry : std::filesystem::directory_iterator{folder})
        if (entry.path().extension() == ".plan") files.push_back(entry.path());
    std::ranges::sort(files);
    return files;
}

}  // namespace shaker::orders
