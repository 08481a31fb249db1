#include "daemon/commands/list_command.hpp"

#include <spdlog/fmt/fmt.h>

#include "daemon/catalogue/recording_summary.hpp"
#include "daemon/report/printing.hpp"
#include "daemon/report/results.hpp"

namespace shaker::commands {

namespace {

std::string row_line(const catalogue::ResultRow& row) {
    std::string line = "  " + row.time;
    if (row.asked)
        line += fmt::format("  gamma {:.4g} m/s^2, phi {:.4g} rad, rho {:.4g}, {:.6g} Hz", row.asked->gamma,
                            row.asked->phi, row.asked->rho, row.asked->frequency);
    if (std::isfinite(row.v_D.value))
        line += "  v_D " + report::with_error(1e3 * row.v_D.value, 1e3 * row.v_D.sigma) + " mm/s";
    if (std::isfinite(row.ratio.value))
        line += "  camera/accelerometer " + report::with_error(row.ratio.value, row.ratio.sigma);
    return line + "  " + row.ended + "\n";
}

}  // namespace

void list_recording(const std::filesystem::path& file, bool json) {
    const std::string name = file.filename().string();
    const catalogue::RecordingSummary s = catalogue::summary_of(recorded::RecordingReader{file}, name);
    if (json) return report::say(catalogue::summary_json(s) + "\n");
    std::string text = fmt::format("{}  {}  {}\n", name, s.started, s.outcome);
    for (const std::string& remark : s.remarks) text += "  remark: " + remark + "\n";
    for (const catalogue::ResultRow& row : s.rows) text += row_line(row);
    report::say(text);
}

}  // namespace shaker::commands
