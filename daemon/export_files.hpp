#pragma once
// The files of an export: only new ones, and none when one of them could not be written.
#include <filesystem>
#include <string>
#include <vector>

#include "daemon/export_tables.hpp"

namespace shaker {

/// Removes what it made unless it is kept.
class NewFiles {
public:
    /// Makes the folder where there is none. InputError when one of the files that are to be made exists.
    NewFiles(std::filesystem::path folder, const std::vector<std::string>& names);
    ~NewFiles();
    NewFiles(const NewFiles&) = delete;
    NewFiles& operator=(const NewFiles&) = delete;
    /// Makes an empty file. InputError when it exists, DeviceError when it cannot be made.
    std::filesystem::path make(const std::string& name);
    void keep() noexcept { made_.clear(); }

private:
    std::filesystem::path folder_;
    std::vector<std::filesystem::path> made_;  // what is to be removed, the folder first if it was made
};

/// A file name, or another name, out of that of a table: "tracks/top/walker" is "tracks-top-walker" joined by
/// '-'.
std::string joined_name(const std::string& table, char by);

/// A line of headings, "name [unit]", and a line for each row; numbers with 17 significant digits, what is
/// not known "nan". Returns the number of rows. DeviceError when it cannot be written.
std::size_t write_csv(ExportTable& table, const std::filesystem::path& file);

/// MAT-file of level 5, compressed: a struct for each table with a column vector for each column (of texts a
/// cell array) and their units in the field "units". Returns the rows of each. InputError for a table that is
/// too large for this format.
std::vector<std::size_t> write_mat(std::vector<ExportTable>& tables, const std::filesystem::path& file);
/// Reads such a file again: DeviceError unless it holds so many variables, each with the checksum it should
/// have.
void require_whole_mat(const std::filesystem::path& file, std::size_t variables);

}  // namespace shaker
