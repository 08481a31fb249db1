#include "calibration/sealed_file.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <iterator>

#include "drivers/errors.hpp"
#include "drivers/text/sha256.hpp"

namespace shaker::calibration {

namespace {
constexpr std::string_view seal = "sha256 = \"";
}

std::string sealed(const std::string& text) { return text + std::string{seal} + text::sha256(text) + "\"\n"; }

void require_seal(const std::string& text, const std::string& file, std::string_view device) {
    const std::size_t end = text.rfind(seal);
    if (end == std::string::npos)
        throw InputError{file + ": is not a calibration file: its last line is not a sha256"};
    if (text != sealed(text.substr(0, end)))
        throw InputError{fmt::format(
            "{}: was changed after it was written (its checksum does not match); restore it or calibrate "
            "again with \"shakerd calibrate {}\"",
            file, device)};
}

std::string sealed_text(const std::filesystem::path& file) {
    std::ifstream in{file, std::ios::binary};
    std::string text{std::istreambuf_iterator<char>{in}, {}};
    if (!in)
        throw InputError{
            fmt::format("calibration file {}: cannot be read: {}", file.string(), std::strerror(errno))};
    return text;
}

std::string toml_number(double x) {
    std::string s = fmt::format("{}", x);
    return s.find_first_of(".en") == std::string::npos ? s + ".0" : s;
}

std::string toml_string(std::string text) {
    std::ranges::replace_if(
        text, [](unsigned char c) { return c < ' ' || c == '"' || c == '\\' || c == 0x7f; }, ' ');
    return '"' + text + '"';
}

}  // namespace shaker::calibration
