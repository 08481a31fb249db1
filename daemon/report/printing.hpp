#pragma once
// Standard output and standard error of shakerd: control characters of files, devices and clients leave as
// text.
#include <spdlog/formatter.h>

#include <cstdio>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>

namespace shaker::report {

/// Writes the text, made printable; its line ends are kept.
void say(std::string_view text, std::FILE* to = stdout);

/// Indented JSON. Bytes that are not UTF-8 are replaced by U+FFFD.
std::string json_text(const nlohmann::json& json);

/// Format of log messages: the message alone, made printable; its line ends are kept.
std::unique_ptr<spdlog::formatter> log_format();

}  // namespace shaker::report
