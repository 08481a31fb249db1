#pragma once
// Texts of the programs that are kept in tests/golden/texts. No test rewrites them: see tests/README.md.
#include <filesystem>
#include <initializer_list>
#include <string>
#include <vector>

namespace shaker::test {

/// Fails with the first different line when `got` is not the kept text `name` ("printed/runs.txt") to the
/// byte. `got` is then in the folder golden of the build, to be compared and copied.
void expect_golden(const std::string& name, const std::string& got);

/// The lines of a kept text that begin with one of these marks ("> "): what a test puts in to get the text.
std::vector<std::string> golden_inputs(const std::string& name, std::initializer_list<const char*> marks);

/// The text with a placeholder for the version of the program, its folders, dates and amounts of time, memory
/// and disk of this computer. folder: the one in which the programs ran; may be empty.
std::string without_place_and_time(std::string text, const std::filesystem::path& folder = {});

/// One JSON text on many lines: a line for each key.
std::string by_keys(const std::string& json);

/// "$ command", what the shell prints in `folder`, lines of standard error behind "! ", and "exit N" unless N
/// is 0. The built programs are found by their names, the project in $SOURCE.
std::string printed_by(const std::string& command, const std::filesystem::path& folder);

}  // namespace shaker::test
