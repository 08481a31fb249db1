#include "daemon/commands/export_command.hpp"

#include <spdlog/fmt/fmt.h>
#include <spdlog/spdlog.h>

#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "daemon/campaign/points_table.hpp"
#include "daemon/export/files.hpp"
#include "daemon/export/tables.hpp"
#include "daemon/recording/tables/places.hpp"
#include "daemon/report/printing.hpp"

namespace shaker::commands {

namespace {

struct Exported {
    std::string table, file;
    std::size_t rows;
};

void print(const std::filesystem::path& folder, const std::vector<Exported>& all, bool json) {
    nlohmann::json list = nlohmann::json::array();
    for (const Exported& e : all) {
        const std::string file = (folder / e.file).string();
        list.push_back({{"table", e.table}, {"file", file}, {"rows", e.rows}});
        if (!json) fmt::print("{:<32} {:>10} rows  {}\n", e.table, e.rows, file);
    }
    if (json) fmt::print("{}\n", report::json_text({{"tables", list}}));
}

}  // namespace

std::filesystem::path export_folder(const ExportOptions& options) {
    if (!options.folder.empty()) return options.folder;
    return options.file.parent_path() / (options.file.stem().string() + ".export");
}

void export_recording(const ExportOptions& options) {
    std::optional<recorded::RecordingReader> recording;
    std::vector<exporting::ExportTable> tables;
    if (campaign::has_points(options.file)) {
        tables = campaign::export_tables(campaign::read_points(options.file));
    } else {
        recording.emplace(options.file);
        recording::require_known_schema(*recording);
        for (const std::string& what : recording->damage())
            spdlog::warn("the recording is damaged: {}", what);
        tables = exporting::export_tables(*recording);
    }
    tables = exporting::chosen(std::move(tables), options.what, options.file);
    const std::filesystem::path folder = export_folder(options);
    std::vector<std::string> names;
    names.reserve(tables.size());
    for (const exporting::ExportTable& t : tables) names.push_back(exporting::joined_name(t.name) + ".csv");
    exporting::NewFiles files{folder, names};
    std::vector<Exported> all;
    for (std::size_t i = 0; i < tables.size(); ++i)
        all.push_back({tables[i].name, names[i], write_csv(tables[i], files.make(names[i]))});
    files.keep();
    print(folder, all, options.json);
}

}  // namespace shaker::commands
