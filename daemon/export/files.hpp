#pragma once
// The files of an export. Existing files are never replaced. If one file cannot be written, all are removed.
#include <filesystem>
#include <string>
#include <vector>

#include "daemon/export/tables.hpp"

namespace shaker::exporting {

/// Creates files, and removes them in its destructor unless keep() was called.
class NewFiles {
public:
    /// Creates the folder if it is missing. InputError if one of `names` exists in it.
    NewFiles(std::filesystem::path folder, const std::vector<std::string>& names);
    ~NewFiles();
    NewFiles(const NewFiles&) = delete;
    NewFiles& operator=(const NewFiles&) = delete;
    /// Creates an empty file. InputError if it exists, DeviceError if it cannot be created.
    std::filesystem::path make(const std::string& name);
    void keep() noexcept { made_.clear(); }

private:
    std::filesystem::path folder_;
    std::vector<std::filesystem::path> made_;  // to be removed; the folder is first if it was created
};

/// Name of a table with hyphens in place of slashes: "tracks/top/walker" becomes "tracks-top-walker".
std::string joined_name(const std::string& table);

/// Writes a line of headings, "name [unit]", and one line per row: numbers with 17 significant digits, "nan"
/// for unknown values. Returns the number of rows. DeviceError if it cannot be written.
std::size_t write_csv(ExportTable& table, const std::filesystem::path& file);

}  // namespace shaker::exporting
