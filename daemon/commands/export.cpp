#include <spdlog/fmt/fmt.h>
#include <spdlog/spdlog.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "daemon/campaign/points_table.hpp"
#include "daemon/commands/table.hpp"
#include "daemon/export/files.hpp"
#include "daemon/export/tables.hpp"
#include "daemon/manual/values.hpp"
#include "daemon/recording/tables/places.hpp"
#include "daemon/report/printing.hpp"
#include "daemon/sandbox/confined.hpp"
#include "daemon/sandbox/new_files.hpp"

namespace shaker::commands {

namespace {

using manual::Argument;
using manual::Kind;

constexpr std::array export_arguments{
    Argument{.name = "FILE",
             .help = "Recording, or points table of a campaign (campaign.nxs)",
             .kind = Kind::file},
    Argument{.name = "--output",
             .letter = 'o',
             .value = "FOLDER",
             .help = "Folder of the files; created if it does not exist",
             .kind = Kind::folder,
             .otherwise = "FILE with the ending .export"},
    Argument{.name = "--what",
             .value = "TABLES",
             .help = "Tables, separated by commas: tracks,accelerometer,results,periods,cycle,drive,... or "
                     "all. \"all\" does not include drive, which has every output sample. An unknown word "
                     "lists the tables",
             .kind = Kind::text,
             .standard = "all",
             .many = true,
             .separator = ','},
    manual::json_argument};

struct Exported {
    std::string table, file;
    std::size_t rows;
};

void print_exported(const std::filesystem::path& folder, const std::vector<Exported>& all, bool json) {
    nlohmann::json list = nlohmann::json::array();
    for (const Exported& e : all) {
        const std::string file = (folder / e.file).string();
        list.push_back({{"table", e.table}, {"file", file}, {"rows", e.rows}});
        if (!json) fmt::print("{:<32} {:>10} rows  {}\n", e.table, e.rows, file);
    }
    if (json) fmt::print("{}\n", report::json_text({{"tables", list}}));
}

// Writes the tables of a recording, or the points table of a campaign, as files into a folder; never
// overwrites a file.
void export_tables(const manual::Values& values, const std::filesystem::path& folder) {
    const std::filesystem::path from = values.text("FILE");
    std::optional<recorded::RecordingReader> recording;
    std::vector<exporting::ExportTable> tables;
    if (campaign::has_points(from)) {
        tables = campaign::export_tables(campaign::read_points(from));
    } else {
        recording.emplace(from);
        recording::require_known_schema(*recording);
        for (const std::string& what : recording->damage())
            spdlog::warn("the recording is damaged: {}", what);
        tables = exporting::export_tables(*recording);
    }
    tables = exporting::chosen(std::move(tables), values.texts("--what"), from);
    std::vector<std::string> names;
    names.reserve(tables.size());
    for (const exporting::ExportTable& t : tables) names.push_back(exporting::joined_name(t.name) + ".csv");
    exporting::NewFiles files{folder, names};
    std::vector<Exported> all;
    for (std::size_t i = 0; i < tables.size(); ++i)
        all.push_back({tables[i].name, names[i], write_csv(tables[i], files.make(names[i]))});
    files.keep();
    print_exported(folder, all, values.has("--json"));
}

int act_on_export(const manual::Values& values) {
    const std::filesystem::path file = values.text("FILE");
    std::filesystem::path folder = values.text("--output");
    if (folder.empty()) folder = file.parent_path() / (file.stem().string() + ".export");
    sandbox::Confinement allowed = sandbox::confinement_for(file);
    const sandbox::NewFolder made{file, folder};
    allowed.files.writes = {std::filesystem::weakly_canonical(folder)};  // the folder may be a link
    return confined(file.string(), allowed, [&] {
        export_tables(values, folder);
        return manual::exit_ok;
    });
}

}  // namespace

manual::Command export_row() {
    return {
        .name = "export",
        .summary = "Write the tables of a recording or campaign as CSV files",
        .details =
            "One file per table; existing files are never overwritten. MATLAB (h5read), Octave (load) and "
            "Python (h5py) also read the recording itself.",
        .arguments = export_arguments,
        .example = "shakerd export run.nxs --what tracks,drive",
        .exit_statuses = {manual::exit_device},
        .act = act_on_export};
}

}  // namespace shaker::commands
