#include <matio.h>
#include <spdlog/fmt/fmt.h>

#include <array>
#include <cctype>
#include <iterator>
#include <memory>
#include <set>

#include "daemon/export/files.hpp"
#include "drivers/errors.hpp"

namespace shaker::exporting {

namespace {

using Variable = std::unique_ptr<matvar_t, decltype(&Mat_VarFree)>;

Variable owned(matvar_t* variable, const std::string& what) {
    if (variable == nullptr) throw DeviceError{what + ": libmatio could not create it"};
    return {variable, &Mat_VarFree};
}

// Level 5 stores the size of a variable in 31 bits.
constexpr std::size_t most_bytes = (std::size_t{1} << 31U) - (std::size_t{1} << 20U);

// A valid and unique name for MATLAB: a letter, then letters, digits and underscores, at most 63 characters.
std::string identifier(const std::string& name, std::set<std::string>& taken) {
    constexpr std::size_t longest = 60;
    std::string id = joined_name(name, '_').substr(0, longest);
    for (char& c : id)
        if (std::isalnum(static_cast<unsigned char>(c)) == 0) c = '_';
    if (id.empty() || std::isalpha(static_cast<unsigned char>(id.front())) == 0) id = "x" + id;
    const std::string first = id;
    for (int k = 2; !taken.insert(id).second; ++k) id = fmt::format("{}{}", first, k);
    return id;
}

Variable struct_of(const std::string& name, const std::vector<std::string>& fields) {
    std::vector<const char*> words;
    words.reserve(fields.size());
    for (const std::string& f : fields) words.push_back(f.c_str());
    std::array<std::size_t, 2> one{1, 1};
    return owned(
        Mat_VarCreateStruct(name.c_str(), 2, one.data(), words.data(), static_cast<unsigned>(words.size())),
        name);
}

matvar_t* text_value(const std::string& text) {
    std::array<std::size_t, 2> shape{text.empty() ? std::size_t{0} : 1, text.size()};
    std::string copy = text;
    return Mat_VarCreate(nullptr, MAT_C_CHAR, MAT_T_UTF8, 2, shape.data(), copy.data(), 0);
}

// Numbers are not copied: the column must outlive the variable.
matvar_t* value_of(std::vector<double>& values) {
    std::array<std::size_t, 2> shape{values.size(), 1};
    return Mat_VarCreate(nullptr, MAT_C_DOUBLE, MAT_T_DOUBLE, 2, shape.data(), values.data(),
                         MAT_F_DONT_COPY_DATA);
}

matvar_t* value_of(std::vector<std::int64_t>& values) {
    std::array<std::size_t, 2> shape{values.size(), 1};
    return Mat_VarCreate(nullptr, MAT_C_INT64, MAT_T_INT64, 2, shape.data(), values.data(),
                         MAT_F_DONT_COPY_DATA);
}

matvar_t* value_of(std::vector<std::string>& values) {
    std::array<std::size_t, 2> shape{values.size(), 1};
    matvar_t* cell = Mat_VarCreate(nullptr, MAT_C_CELL, MAT_T_CELL, 2, shape.data(), nullptr, 0);
    for (std::size_t i = 0; cell != nullptr && i < values.size(); ++i)
        Mat_VarSetCell(cell, static_cast<int>(i), text_value(values[i]));
    return cell;
}

std::size_t bytes_of(const std::vector<ExportColumn>& columns) {
    return 8 * rows_of(columns) * columns.size();
}

// All rows of a table.
std::vector<ExportColumn> whole(ExportTable& table) {
    std::vector<ExportColumn> all = table.columns;
    while (table.next(table.columns)) {
        for (std::size_t i = 0; i < all.size(); ++i)
            std::visit(
                [&](auto& to) {
                    auto& from = std::get<std::remove_reference_t<decltype(to)>>(table.columns[i].values);
                    to.insert(to.end(), from.begin(), from.end());
                },
                all[i].values);
        if (bytes_of(all) > most_bytes)
            throw InputError{
                fmt::format("{}: more than {} rows are too many for a MAT-file of level 5; --format csv has "
                            "no such limit",
                            table.name, rows_of(all))};
    }
    return all;
}

Variable variable_of(const std::string& name, std::vector<ExportColumn>& columns) {
    std::set<std::string> taken{"units"};
    std::vector<std::string> fields;
    fields.reserve(columns.size());
    for (const ExportColumn& c : columns) fields.push_back(identifier(c.name, taken));
    Variable units = struct_of("units", fields);
    std::vector<std::string> with_units = fields;
    with_units.emplace_back("units");
    Variable table = struct_of(name, with_units);
    for (std::size_t i = 0; i < columns.size(); ++i) {
        matvar_t* value = std::visit([](auto& values) { return value_of(values); }, columns[i].values);
        Mat_VarSetStructFieldByName(table.get(), fields[i].c_str(), 0,
                                    owned(value, columns[i].name).release());
        Mat_VarSetStructFieldByName(units.get(), fields[i].c_str(), 0,
                                    owned(text_value(columns[i].units), columns[i].name).release());
    }
    Mat_VarSetStructFieldByName(table.get(), "units", 0, units.release());
    return table;
}

}  // namespace

std::vector<std::size_t> write_mat(std::vector<ExportTable>& tables, const std::filesystem::path& file) {
    // A fixed header instead of libmatio's time stamp: the same recording gives the same bytes.
    std::unique_ptr<mat_t, decltype(&Mat_Close)> mat{
        Mat_CreateVer(file.c_str(), "MATLAB 5.0 MAT-file, by shakerd " SHAKER_VERSION, MAT_FT_MAT5),
        &Mat_Close};
    if (!mat) throw DeviceError{file.string() + ": libmatio cannot write it"};
    std::vector<std::size_t> rows;
    std::set<std::string> taken;
    for (ExportTable& t : tables) {
        std::vector<ExportColumn> columns = whole(t);
        t.columns.clear();
        const Variable variable = variable_of(identifier(t.name, taken), columns);
        if (const int error = Mat_VarWrite(mat.get(), variable.get(), MAT_COMPRESSION_ZLIB); error != 0)
            throw DeviceError{
                fmt::format("{}: libmatio could not write \"{}\" (error {})", file.string(), t.name, error)};
        rows.push_back(rows_of(columns));
    }
    mat.reset();
    require_whole_mat(file, rows.size());
    return rows;
}

}  // namespace shaker::exporting
