#include <spdlog/spdlog.h>

#include <algorithm>
#include <span>

#include "daemon/campaign/campaign_folder.hpp"
#include "daemon/commands/mu.hpp"
#include "daemon/commands/table.hpp"
#include "daemon/manual/values.hpp"
#include "daemon/report/installed.hpp"
#include "daemon/sandbox/outside_program.hpp"
#include "drivers/errors.hpp"
#include "drivers/recorded/h5/disk_file.hpp"

namespace shaker::commands {

namespace {

using manual::Argument;
using manual::Kind;

constexpr const char* python = "/usr/bin/python3";

constexpr std::array report_arguments{
    Argument{.name = "FILE",
             .help =
                 "Folder of a campaign, or its campaign.nxs; several are compared in the same figures. Or "
                 "recordings: one page for all of them",
             .kind = Kind::file,
             .many = true},
    Argument{.name = "--output",
             .letter = 'o',
             .value = "FOLDER",
             .help = "Folder of report.html and of each figure as SVG, PDF and PNG",
             .kind = Kind::folder,
             .otherwise =
                 "\"report\" in the folder of the first campaign; the first recording with the ending "
                 ".report"},
    Argument{.name = "--fits",
             .value = "FILE",
             .help = "Fits and budgets of another program: JSON as of \"shakerd mu\", or a list of that for "
                     "several campaigns",
             .kind = Kind::file,
             .otherwise = "those of \"shakerd mu\""}};

std::filesystem::path scripts() {
    if (auto folder = report::installed("report"); !folder.empty()) return folder;
    throw InputError{
        "the scripts of the report are not installed: there is no share/shakerd/report/report.py"};
}

bool is_campaign(const std::filesystem::path& place) {
    return std::filesystem::is_directory(place) || place.filename() == campaign::table_name;
}

/// The fits of a campaign as JSON. "{}" for a recording, and, with a message, for a campaign without a
/// measured point or with fits of more than 1 MiB.
std::string fits_of(const std::filesystem::path& place) {
    if (!is_campaign(place)) return "{}";
    const std::vector<std::filesystem::path> file{points_file(place)};
    try {
        const sandbox::Answer answer = sandbox::ask_confined(place.string(), confinement_for_points(file),
                                                             [&] { return mu_text(file, {}, true); });
        return answer.status == manual::exit_ok ? answer.text : "{}";
    } catch (const InputError& error) {
        spdlog::warn("{}; the report has no fits of it", error.what());
        return "{}";
    }
}

/// Writes the fits of each campaign by itself into the report's folder, as a JSON list. A link of that name
/// is replaced, not followed.
std::filesystem::path own_fits(const std::vector<std::filesystem::path>& places,
                               const std::filesystem::path& out) {
    std::string list;
    for (const std::filesystem::path& place : places) list += (list.empty() ? "[" : ",\n") + fits_of(place);
    list += "]\n";
    h5::replace_file(out / "fits.json", std::as_bytes(std::span{list}));
    return out / "fits.json";
}

std::filesystem::path default_folder(const std::filesystem::path& place) {
    if (std::filesystem::is_directory(place)) return place / "report";
    if (is_campaign(place)) return place.parent_path() / "report";
    return std::filesystem::path{place}.replace_extension(".report");
}

int act_on_report(const manual::Values& values) {
    const std::filesystem::path code = scripts();
    std::filesystem::path out = values.text("--output");
    sandbox::OutsideProgram program{.words = {python, "-I", "-B", (code / "report.py").string()}};
    program.files.reads.push_back(code);
    std::vector<std::filesystem::path> places;
    for (const std::string& word : values.texts("FILE")) {
        const std::filesystem::path place = std::filesystem::absolute(word);
        if (!std::filesystem::exists(place))
            throw InputError{word +
                             ": no such file or folder; expected the folder of a campaign, or a recording"};
        if (is_campaign(place)) points_file(place);  // refuses a folder without a points table
        if (out.empty()) out = default_folder(place);
        places.push_back(place);
        program.words.push_back(place.string());
        program.files.reads.push_back(place.filename() == campaign::table_name ? place.parent_path() : place);
    }
    if (values.text("--output").empty() && std::filesystem::is_symlink(out))
        throw InputError{out.string() + ": is a link, which is not followed; name a folder by --output"};
    std::filesystem::create_directories(out);
    out = std::filesystem::canonical(out);
    program.files.writes.push_back(out);
    program.words.insert(program.words.end(), {"-o", out.string()});
    std::filesystem::path fits = values.text("--fits");
    if (fits.empty() && std::ranges::any_of(places, is_campaign)) fits = own_fits(places, out);
    if (!fits.empty()) {
        fits = std::filesystem::absolute(fits);
        program.words.insert(program.words.end(), {"--fits", fits.string()});
        program.files.reads.push_back(fits);
    }
    // For the law's curves.
    const std::string self = std::filesystem::read_symlink("/proc/self/exe").string();
    program.files.runs.emplace_back(self);
    program.settings = {"PATH=/usr/bin", "LANG=C.UTF-8", "HOME=" + out.string(), "TMPDIR=" + out.string(),
                        "SHAKERD=" + self};
    return run_outside(program);
}

}  // namespace

manual::Command report_row() {
    return {.name = "report",
            .summary = "Draw campaigns as the paper's figures; or single recordings",
            .details =
                "Needs python3-h5py and python3-matplotlib. Its scripts are in share/shakerd/report, to "
                "take and change.",
            .arguments = report_arguments,
            .example = "shakerd report paper",
            .act = act_on_report};
}

}  // namespace shaker::commands
