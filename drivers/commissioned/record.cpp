#include "drivers/commissioned/record.hpp"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>

#include "drivers/errors.hpp"
#include "drivers/settings_table.hpp"
#include "drivers/text/sha256.hpp"

namespace shaker::commissioned {

namespace {

// A TOML string. Names of devices have no quotes and no control characters worth keeping.
std::string quoted(std::string text) {
    std::ranges::replace_if(
        text, [](unsigned char c) { return c < ' ' || c == '"' || c == '\\'; }, ' ');
    return '"' + text + '"';
}

}  // namespace

std::filesystem::path record_of(const std::filesystem::path& rig) { return rig.string() + ".commissioned"; }

void write_record(const std::filesystem::path& rig, const std::string& rig_text, const std::string& date,
                  const std::vector<Item>& items) {
    std::ofstream out{record_of(rig)};
    out << "# Commissioning of " << rig.filename().string() << ", valid while that file is unchanged.\n"
        << "date = " << quoted(date) << "\nrig_sha256 = " << quoted(text::sha256(rig_text)) << "\n";
    for (const Item& item : items)
        out << "\n[[item]]\nname = " << quoted(item.name) << "\nresult = " << quoted(item.result) << "\n";
    out.close();
    if (!out) throw DeviceError{record_of(rig).string() + ": " + std::strerror(errno)};
}

std::string missing_record(const std::filesystem::path& rig, const std::string& rig_text) {
    const std::string remedy = "; run: shakerd check --commission --rig " + rig.string();
    const std::filesystem::path file = record_of(rig);
    if (!std::filesystem::exists(file))
        return "this bench has not been commissioned: there is no " + file.string() + remedy;
    try {
        if (SettingsTable::from_file(file).text("rig_sha256") == text::sha256(rig_text)) return {};
    } catch (const InputError& e) {
        return e.what() + remedy;
    }
    return rig.string() + " has changed since the bench was commissioned" + remedy;
}

}  // namespace shaker::commissioned
