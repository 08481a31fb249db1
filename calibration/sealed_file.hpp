#pragma once
// Calibration files: TOML whose last line is the SHA-256 of the lines above.
#include <filesystem>
#include <string>
#include <string_view>

namespace shaker::calibration {

/// Adds the line with the checksum.
std::string sealed(const std::string& text);

/// InputError names the file, and states when it was changed after it was written; `device` is the word of
/// "shakerd calibrate".
void require_seal(const std::string& text, const std::string& file, std::string_view device);

/// The content of a calibration file. InputError for a file that cannot be read.
std::string sealed_text(const std::filesystem::path& file);

/// TOML: the shortest float that reads back the same, and a string without special characters.
std::string toml_number(double x);
std::string toml_string(std::string text);

/// An array, with a line for each `in_a_row` numbers.
template <class Numbers>
std::string toml_list(const Numbers& all, std::size_t in_a_row) {
    std::string text = "[";
    for (std::size_t i = 0; i < all.size(); ++i)
        text += (i == 0 ? "" : i % in_a_row == 0 ? ",\n  " : ", ") + toml_number(all[i]);
    return text + "]\n";
}

}  // namespace shaker::calibration
