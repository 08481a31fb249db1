#include "daemon/commands/calibrate/strip_command.hpp"

#include <spdlog/fmt/fmt.h>

#include "calibration/camera/printed_targets.hpp"
#include "daemon/commands/calibrate/new_file.hpp"
#include "daemon/report/printing.hpp"

namespace shaker::commands {

void print_strip(const optics::BarCode& code, double height_mm, const std::filesystem::path& output) {
    constexpr std::size_t fewest_edges = 8;
    if (code.least_mm > code.most_mm)
        throw InputError{
            fmt::format("--bar-least {} mm: must be at most --bar-most, {} mm", code.least_mm, code.most_mm)};
    const std::size_t edges = optics::edges_of(code).size();
    if (edges < fewest_edges)
        throw InputError{
            fmt::format("--strip-length {} mm: has {} edges; tracking needs {} in view; narrower "
                        "bars or a longer strip have more",
                        code.length_mm, edges, fewest_edges)};
    NewFile{output}.append(calibration::strip_pdf(code, height_mm));
    report::say(
        fmt::format("written: {}; print at 100 % and measure the line under the strip\n"
                    "{} edges; bars of {:g} to {:g} mm; in the picture a bar should be 6 px or wider\n"
                    "for the table of the target: kind = \"code\"\n",
                    output.string(), edges, code.least_mm, code.most_mm));
}

}  // namespace shaker::commands
