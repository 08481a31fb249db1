#include "daemon/export/tables.hpp"

#include <spdlog/fmt/fmt.h>
#include <spdlog/fmt/ranges.h>

#include <algorithm>
#include <iterator>
#include <set>
#include <utility>

#include "daemon/export/streams.hpp"
#include "daemon/recording/tables/places.hpp"
#include "drivers/errors.hpp"

namespace shaker::exporting {

namespace {

constexpr const char* on_request = "drive";  // very large, so only exported if named

std::string path_of(const recorded::GroupLayout& group, const recorded::Place& place) {
    return group.path + "/" + place.name;
}

ExportColumn heading_of(const recorded::Place& place) {
    const bool text = place.kind == recorded::Place::Kind::text || place.kind == recorded::Place::Kind::texts;
    ExportColumn column{place.name, place.units, std::vector<double>{}};
    if (text) column.values = std::vector<std::string>{};
    return column;
}

void read(const recorded::RecordingReader& file, const std::string& path, recorded::Place::Kind kind,
          ExportColumn& column) {
    switch (kind) {
        case recorded::Place::Kind::number:
            column.values = std::vector<double>{file.scalar(path)};
            break;
        case recorded::Place::Kind::text:
            column.values = std::vector<std::string>{file.text(path)};
            break;
        case recorded::Place::Kind::numbers:
            column.values = file.numbers(path);
            break;
        case recorded::Place::Kind::texts:
            column.values = file.texts(path);
            break;
    }
}

// The columns of a group; single numbers and texts form one row.
ExportTable stored_table(const recorded::RecordingReader& file, const recorded::GroupLayout& group) {
    std::vector<ExportColumn> headings;
    for (const recorded::Place& p : group.places) headings.push_back(heading_of(p));
    return {group.path, std::move(headings),
            [&file, group, done = false](std::vector<ExportColumn>& columns) mutable {
                if (std::exchange(done, true)) return false;
                for (std::size_t i = 0; i < columns.size(); ++i) {
                    read(file, path_of(group, group.places[i]), group.places[i].kind, columns[i]);
                    const auto rows = std::visit([](const auto& v) { return v.size(); }, columns[i].values);
                    if (rows != rows_of(columns))
                        throw InputError{"recording: " + group.path + " has columns of different length"};
                }
                return true;
            }};
}

bool is_there(const recorded::RecordingReader& file, const recorded::GroupLayout& group) {
    return !group.places.empty() && std::ranges::all_of(group.places, [&](const recorded::Place& p) {
        return file.has(path_of(group, p));
    });
}

std::string word_of(const ExportTable& table) { return table.name.substr(0, table.name.find('/')); }

}  // namespace

std::size_t rows_of(const std::vector<ExportColumn>& columns) {
    return columns.empty() ? 0 : std::visit([](const auto& v) { return v.size(); }, columns.front().values);
}

std::vector<ExportTable> export_tables(const recorded::RecordingReader& file) {
    const recorded::RecordingHeader& header = file.header();
    std::vector<ExportTable> tables;
    for (const recorded::GroupLayout& group : recording::recording_places(header, file.has("truth")))
        if (is_there(file, group)) tables.push_back(stored_table(file, group));
    if (header.accelerometer.rate_hz > 0) tables.push_back(accelerometer_table(file));
    for (const View& view : header.views) tables.push_back(frames_table(file, view.camera));
    if (header.dac.rate_hz > 0) {
        tables.push_back(changes_table(file));
        tables.push_back(plays_table(file));
        tables.push_back(drive_table(file));
    }
    return tables;
}

std::vector<ExportTable> chosen(std::vector<ExportTable> tables, const std::vector<std::string>& what,
                                const std::filesystem::path& file) {
    std::set<std::string> words, wanted{what.begin(), what.end()};
    for (const ExportTable& t : tables) words.insert(word_of(t));
    if (wanted.erase("all") > 0)
        std::ranges::copy_if(words, std::inserter(wanted, wanted.end()),
                             [](const std::string& word) { return word != on_request; });
    for (const std::string& word : wanted)
        if (!words.contains(word))
            throw InputError{
                fmt::format("--what {}: {} has no such table; it has {}; \"all\" is every table except {}",
                            word, file.string(), fmt::join(words, ", "), on_request)};
    std::erase_if(tables, [&](const ExportTable& t) { return !wanted.contains(word_of(t)); });
    return tables;
}

}  // namespace shaker::exporting
