#include "tests/support/golden.hpp"

#include <gtest/gtest.h>
#include <sys/wait.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <regex>
#include <sstream>
#include <utility>

#include "tests/support/paths.hpp"

namespace shaker::test {

namespace {

std::string content(const std::filesystem::path& file) {
    std::ifstream in{file, std::ios::binary};
    return {std::istreambuf_iterator<char>{in}, {}};
}

std::filesystem::path kept(const std::string& name) { return source_dir() + "/tests/golden/texts/" + name; }

/// At most 160 bytes of a line, around one of them.
std::string part_of(const std::string& line, std::size_t at) {
    constexpr std::size_t before = 60, most = 160;
    return line.size() <= most ? line : "..." + line.substr(at > before ? at - before : 0, most) + "...";
}

/// The first line in which two texts differ, from both.
std::string first_difference(const std::string& expected, const std::string& got) {
    std::istringstream a{expected}, b{got};
    std::string x, y;
    for (int line = 1;; ++line) {
        const bool ended = !std::getline(a, x);
        if (ended) x = "(the end)";
        if (!std::getline(b, y)) y = "(the end)";
        if (x == y && !ended) continue;
        const auto at = static_cast<std::size_t>(std::ranges::mismatch(x, y).in1 - x.begin());
        return "line " + std::to_string(line) + "\n  expected: " + part_of(x, at) +
               "\n  got:      " + part_of(y, at);
    }
}

void replace_all(std::string& text, const std::string& what, const std::string& by) {
    if (what.empty()) return;
    for (auto at = text.find(what); at != std::string::npos; at = text.find(what, at + by.size()))
        text.replace(at, what.size(), by);
}

}  // namespace

void expect_golden(const std::string& name, const std::string& got) {
    const std::filesystem::path written = std::filesystem::path{build_dir()} / "golden" / name;
    std::filesystem::remove(written);
    const std::string expected = content(kept(name));
    if (got == expected) return;
    std::filesystem::create_directories(written.parent_path());
    std::ofstream{written, std::ios::binary} << got;
    ADD_FAILURE() << "tests/golden/texts/" << name << ", " << first_difference(expected, got)
                  << "\n  the new text: " << written.string();
}

std::vector<std::string> golden_inputs(const std::string& name, std::initializer_list<const char*> marks) {
    std::istringstream lines{content(kept(name))};
    std::vector<std::string> inputs;
    for (std::string line; std::getline(lines, line);)
        if (std::ranges::any_of(marks, [&](const char* mark) { return line.starts_with(mark); }))
            inputs.push_back(line);
    EXPECT_FALSE(inputs.empty()) << kept(name) << " has no line for the test";
    return inputs;
}

std::string without_place_and_time(std::string text, const std::filesystem::path& folder) {
    replace_all(text, folder.string(), "FOLDER");
    replace_all(text, build_dir(), "BUILD");
    replace_all(text, source_dir(), "SOURCE");
    static const std::array<std::pair<std::regex, const char*>, 3> volatile_parts{
        {{std::regex{R"(\b)" + std::regex_replace(std::string{SHAKER_VERSION}, std::regex{R"(\.)"}, R"(\.)") +
                     R"(\b)"},
          "VERSION"},
         {std::regex{R"(\b2\d{3}-?\d\d-?\d\d[T ]\d\d:?\d\d:?\d\d(\.\d+)?(Z|[+-]\d\d:\d\d)?)"}, "DATE"},
         {std::regex{R"(in \S+ s, \S+ times real time; rendering of pictures took \S+ s \(\d+ %\))"},
          "in TIME"}}};
    for (const auto& [what, by] : volatile_parts) text = std::regex_replace(text, what, by);
    return text;
}

std::string by_keys(const std::string& json) {
    std::string text = json;
    replace_all(text, ",\"", ",\n\"");
    return text + '\n';
}

std::string printed_by(const std::string& command, const std::filesystem::path& folder) {
    std::ofstream{folder / ".command"} << command << '\n';
    const std::string line = "cd '" + folder.string() + "' && SOURCE='" + source_dir() + "' PATH='" +
                             build_dir() + "':$PATH sh .command >.out 2>.err </dev/null";
    const int status = std::system(line.c_str());
    std::string text = "$ " + command + '\n' + content(folder / ".out");
    std::istringstream lines{content(folder / ".err")};
    for (std::string e; std::getline(lines, e);) text += "! " + e + '\n';
    if (status != 0) text += "exit " + std::to_string(WEXITSTATUS(status)) + '\n';
    return text;
}

}  // namespace shaker::test
