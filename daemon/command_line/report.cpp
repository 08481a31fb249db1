#include <span>

#include "daemon/command_line/confined_mu.hpp"
#include "daemon/command_line/rows.hpp"
#include "daemon/commands/mu/mu_command.hpp"
#include "daemon/sandbox/outside_program.hpp"
#include "drivers/errors.hpp"
#include "drivers/recorded/h5/disk_file.hpp"

namespace shaker::command_line {

namespace {

using manual::Argument;
using manual::Kind;

constexpr const char* python = "/usr/bin/python3";

constexpr std::array arguments{
    Argument{.name = "CAMPAIGN",
             .help = "Folder of a campaign, or its campaign.nxs; several are compared in the same figures",
             .kind = Kind::file,
             .many = true},
    Argument{.name = "--output",
             .letter = 'o',
             .value = "FOLDER",
             .help = "Folder of report.html and of each figure as SVG, PDF and PNG",
             .kind = Kind::folder,
             .otherwise = "\"report\" in the folder of the first campaign"},
    Argument{.name = "--fits",
             .value = "FILE",
             .help = "Fits and budgets of another program (JSON)",
             .kind = Kind::file,
             .otherwise = "those of \"shakerd mu\""}};

/// Beside an installed program, or in the folder of the build.
std::filesystem::path scripts() {
    const std::filesystem::path program = std::filesystem::read_symlink("/proc/self/exe").parent_path();
    for (const auto& folder : {program.parent_path() / "share/shakerd/report", program / "report"})
        if (std::filesystem::exists(folder / "report.py")) return std::filesystem::canonical(folder);
    throw InputError{
        "the scripts of the report are not installed: there is no share/shakerd/report/report.py"};
}

/// Writes the fits of `shakerd mu` into the report's folder and returns the file's name; without fits an
/// empty name. A link of that name is replaced, not followed.
std::string own_fits(const std::vector<std::filesystem::path>& campaigns, const std::filesystem::path& out) {
    commands::MuOptions options{.json = true};
    for (const std::filesystem::path& campaign : campaigns)
        options.campaigns.push_back(commands::points_file(campaign));
    const sandbox::Answer answer =
        sandbox::ask_confined(campaigns.front().string(), confinement_for_points(options.campaigns),
                              [&] { return commands::mu_text(options); });
    if (answer.status != manual::exit_ok) return {};
    const std::filesystem::path file = out / "fits.json";
    h5::replace_file(file, std::as_bytes(std::span{answer.text}));
    return file.string();
}

int act(const manual::Values& values) {
    const std::filesystem::path code = scripts();
    std::filesystem::path out = values.text("--output");
    sandbox::OutsideProgram program{.words = {python, "-I", "-B", (code / "report.py").string()}};
    program.files.reads.push_back(code);
    std::vector<std::filesystem::path> campaigns;
    for (const std::string& word : values.texts("CAMPAIGN")) {
        const std::filesystem::path place = std::filesystem::absolute(word);
        if (!std::filesystem::exists(place))
            throw InputError{word + ": no such file or folder; expected the folder of a campaign"};
        const bool whole = std::filesystem::is_directory(place);
        if (out.empty()) out = (whole ? place : place.parent_path()) / "report";
        campaigns.push_back(place);
        program.words.push_back(place.string());
        program.files.reads.push_back(whole ? place : place.parent_path());
    }
    if (values.text("--output").empty() && std::filesystem::is_symlink(out))
        throw InputError{out.string() + ": is a link, which is not followed; name a folder by --output"};
    std::filesystem::create_directories(out);
    out = std::filesystem::canonical(out);
    program.files.writes.push_back(out);
    program.words.insert(program.words.end(), {"-o", out.string()});
    std::string fits = values.text("--fits");
    if (fits.empty()) fits = own_fits(campaigns, out);
    if (!fits.empty()) {
        const std::filesystem::path file = std::filesystem::absolute(fits);
        program.words.insert(program.words.end(), {"--fits", file.string()});
        program.files.reads.push_back(file);
    }
    program.settings = {"PATH=/usr/bin", "LANG=C.UTF-8", "HOME=" + out.string(), "TMPDIR=" + out.string()};
    return run_outside(program);
}

}  // namespace

manual::Command report_row() {
    return {.name = "report",
            .summary = "Draw the paper's figures, fits and numbers from campaigns",
            .details =
                "Needs python3-h5py and python3-matplotlib. Its scripts are in share/shakerd/report, to "
                "take and change.",
            .arguments = arguments,
            .example = "shakerd report paper",
            .act = act};
}

}  // namespace shaker::command_line
