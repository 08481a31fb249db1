#include "tests/support/recording/format_page.hpp"

#include <gtest/gtest.h>
#include <spdlog/fmt/fmt.h>

#include <fstream>
#include <iterator>

#include "daemon/recording/tables/places.hpp"
#include "drivers/recorded/raw_columns.hpp"
#include "tests/support/paths.hpp"

namespace shaker::test {

namespace {

constexpr const char* begin = "<!-- tables -->\n";
constexpr const char* end = "<!-- end of tables -->\n";
constexpr const char* heading = "| column | type | unit | meaning |\n|---|---|---|---|\n";

const char* word_of(recorded::Place::Kind kind) {
    switch (kind) {
        case recorded::Place::Kind::number:
            return "one float64";
        case recorded::Place::Kind::text:
            return "one text";
        case recorded::Place::Kind::numbers:
            return "float64";
        case recorded::Place::Kind::texts:
            return "text";
    }
    return "";
}

const char* word_of(recorded::RawColumn::Type type) {
    switch (type) {
        case recorded::RawColumn::Type::int32:
            return "int32";
        case recorded::RawColumn::Type::int64:
            return "int64";
        case recorded::RawColumn::Type::uint8:
            return "uint8";
        case recorded::RawColumn::Type::uint64:
            return "uint64";
        case recorded::RawColumn::Type::float64:
            return "float64";
    }
    return "";
}

std::string row(const std::string& name, const std::string& type, const std::string& units,
                const std::string& meaning) {
    std::string cell = meaning;  // a bar would end it
    for (std::size_t at = 0; (at = cell.find('|', at)) != std::string::npos; at += 2) cell.insert(at, "\\");
    return fmt::format("| `{}` | {} | {} | {} |\n", name, type, units, cell);
}

std::string section_of(const recorded::GroupLayout& group) {
    std::string text = fmt::format("\n### `{}`\n{}.", group.path, group.meaning);
    if (const auto signal = group.attributes.find("signal"); signal != group.attributes.end())
        text += fmt::format(" NXdata: `{}` against `{}`.", signal->second, group.attributes.at("axes"));
    text += fmt::format("\n\n{}", heading);
    for (const recorded::Place& p : group.places) {
        const bool texts = p.kind == recorded::Place::Kind::text || p.kind == recorded::Place::Kind::texts;
        const std::string type = texts ? fmt::format("{} of {} bytes", word_of(p.kind), p.text_bytes)
                                       : std::string{word_of(p.kind)};
        text += row(p.name, type, p.units, p.provisional ? p.meaning + "; provisional" : p.meaning);
    }
    return text;
}

std::string section_of(const std::string& path, const char* meaning,
                       const std::vector<recorded::RawColumn>& columns) {
    std::string text = fmt::format("\n### `{}`\n{}.\n\n{}", path, meaning, heading);
    for (const recorded::RawColumn& c : columns) {
        const std::string values = c.values > 1 ? fmt::format("{} of ", c.values) : std::string{};
        text += row(c.name, values + word_of(c.type), c.units, c.meaning);
    }
    return text;
}

std::string with_tables(const std::string& page, const std::string& tables) {
    const std::size_t from = page.find(begin), to = page.find(end);
    if (from == std::string::npos || to == std::string::npos) return page;
    return page.substr(0, from) + begin + tables + page.substr(to);
}

}  // namespace

std::string with_tables(const std::string& page) {
    recorded::RecordingHeader header;
    View view;
    view.camera = "<camera>";
    view.targets.push_back({});
    view.targets.back().name = "<target>";
    header.views = {view};
    std::string tables;
    for (const recorded::GroupLayout& g : recording::recording_places(header, true)) tables += section_of(g);
    namespace raw = recorded::raw;
    tables +=
        section_of(raw::drive, "times at which samples of the drive left the converter, one row per block",
                   {raw::plays.begin(), raw::plays.end()});
    tables +=
        section_of(raw::changes, "changes of the drive, sufficient to reproduce every sample to the bit",
                   {raw::drive_changes.begin(), raw::drive_changes.end()});
    std::vector<recorded::RawColumn> accelerometer{raw::counts},
        frames{raw::frames.begin(), raw::frames.end()};
    accelerometer.insert(accelerometer.end(), raw::blocks.begin(), raw::blocks.end());
    tables += section_of(raw::accelerometer, "accelerometer", accelerometer);
    frames.push_back(raw::sightings);
    tables += section_of("raw/<camera>", "frames of one camera", frames);
    return with_tables(page, tables);
}

std::string with_tables(const std::string& page, const std::vector<recorded::GroupLayout>& groups) {
    std::string tables;
    for (const recorded::GroupLayout& g : groups) tables += section_of(g);
    return with_tables(page, tables);
}

void expect_page(const std::string& page, const std::function<std::string(const std::string&)>& with) {
    const std::string file = source_dir() + "/" + page;
    std::ifstream in{file};
    const std::string now{std::istreambuf_iterator<char>{in}, {}}, expected = with(now);
    EXPECT_NE(now.find("\n### `"), std::string::npos) << file << " has no tables";
    if (now == expected) return;
    const std::string made = build_dir() + "/" + page.substr(page.rfind('/') + 1);
    std::ofstream{made} << expected;
    ADD_FAILURE() << "the tables of " << file << " differ from the code; check the differences, then\n  cp "
                  << made << " " << file;
}

}  // namespace shaker::test
