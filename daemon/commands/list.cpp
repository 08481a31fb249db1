#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "daemon/catalogue/recording_summary.hpp"
#include "daemon/commands/table.hpp"
#include "daemon/manual/values.hpp"
#include "daemon/report/printing.hpp"
#include "daemon/sandbox/confined.hpp"
#include "drivers/with_error.hpp"

namespace shaker::commands {

namespace {

using manual::Argument;
using manual::Kind;

constexpr std::array list_arguments{
    Argument{.name = "FILE",
             .help = "Recording; several are listed one after the other",
             .kind = Kind::file,
             .many = true},
    Argument{.name = "--json", .help = "Print one JSON object a line; key names carry the SI units"}};

std::string row_line(const catalogue::ResultRow& row) {
    std::string line = "  " + row.time;
    if (row.asked)
        line += fmt::format("  gamma {:.4g} m/s^2, phi {:.4g} rad, rho {:.4g}, {:.6g} Hz", row.asked->gamma,
                            row.asked->phi, row.asked->rho, row.asked->frequency);
    if (std::isfinite(row.v_D.value))
        line += "  v_D " + with_error(1e3 * row.v_D.value, 1e3 * row.v_D.sigma) + " mm/s";
    if (std::isfinite(row.ratio.value))
        line += "  camera/accelerometer " + with_error(row.ratio.value, row.ratio.sigma);
    return line + "  " + row.ended + "\n";
}

// Prints time, outcome, remarks and measurements of a recording; json: all of it as one line of JSON.
void list_recording(const std::filesystem::path& file, bool json) {
    const std::string name = file.filename().string();
    const catalogue::RecordingSummary s = catalogue::summary_of(recorded::RecordingReader{file}, name);
    if (json) return report::say(catalogue::summary_json(s) + "\n");
    std::string text = fmt::format("{}  {}  {}\n", name, s.started, s.outcome);
    for (const std::string& remark : s.remarks) text += "  remark: " + remark + "\n";
    for (const catalogue::ResultRow& row : s.rows) text += row_line(row);
    report::say(text);
}

int act_on_list(const manual::Values& values) {
    int status = manual::exit_ok;
    for (const std::string& file : values.texts("FILE"))
        status = std::max(status, sandbox::confined(file, sandbox::confinement_for(file), [&] {
                              list_recording(file, values.has("--json"));
                              return manual::exit_ok;
                          }));
    return status;
}

}  // namespace

manual::Command list_row() {
    return {
        .name = "list",
        .summary = "List set-points, results, outcome and remarks of recordings",
        .details = "The results are those that the recording has; \"shakerd replay\" computes them again.",
        .arguments = list_arguments,
        .example = "shakerd list *.nxs",
        .exit_statuses = {manual::exit_device},
        .act = act_on_list};
}

}  // namespace shaker::commands
