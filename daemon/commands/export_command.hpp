#pragma once
// shakerd export: the tables of a recording or of a campaign for other programs.
#include <filesystem>
#include <string>
#include <vector>

namespace shaker::commands {

struct ExportOptions {
    std::filesystem::path file;
    std::filesystem::path folder;          // empty: beside FILE, with its name and the ending .export
    std::vector<std::string> what{"all"};  // first words of the tables' names
    bool json = false;
};
/// Folder of the files.
std::filesystem::path export_folder(const ExportOptions& options);
/// Writes the tables of a recording, or the points table of a campaign, as files; never overwrites a file.
void export_recording(const ExportOptions& options);

}  // namespace shaker::commands
