#pragma once
// shakerd calibrate strip: bars for the base, to print.
#include <filesystem>

#include "drivers/optics/bar_code.hpp"

namespace shaker::commands {

/// Writes the strip as a PDF and prints how to check it. The file is not overwritten. InputError if the
/// widths do not fit or the strip has too few edges for tracking.
void print_strip(const optics::BarCode& code, double height_mm, const std::filesystem::path& output);

}  // namespace shaker::commands
