#include "drivers/commissioned/record.hpp"

#include <spdlog/fmt/fmt.h>
#include <spdlog/fmt/ranges.h>
#include <toml++/toml.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>

#include "drivers/errors.hpp"
#include "drivers/mixer/mixer.hpp"
#include "drivers/settings_table.hpp"
#include "drivers/text/sha256.hpp"

namespace shaker::commissioned {

std::string rig_hash(const std::string& rig_text) { return text::sha256(rig_text); }

std::filesystem::path record_of(const std::filesystem::path& rig) { return rig.string() + ".commissioned"; }

void write_record(const std::filesystem::path& rig, const Record& record) {
    toml::array files, items;
    for (const Named& file : record.files)
        files.push_back(toml::table{{"what", file.what}, {"text", file.text}});
    for (const Item& item : record.items)
        items.push_back(toml::table{{"name", item.name}, {"result", item.result}});
    const toml::table table{
        {"date", record.date}, {"rig_sha256", record.rig_sha256}, {"file", files}, {"item", items}};
    // Strings of several lines are not written as they are read back: all are escaped.
    constexpr toml::format_flags plain =
        toml::toml_formatter::default_flags &
        ~(toml::format_flags::allow_literal_strings | toml::format_flags::allow_multi_line_strings);
    std::ofstream out{record_of(rig)};
    out << "# Commissioning of " << rig.filename().string()
        << ", valid while that file and the files that it names are unchanged.\n"
        << toml::toml_formatter{table, plain} << "\n";
    out.close();
    if (!out) throw DeviceError{record_of(rig).string() + ": " + std::strerror(errno)};
}

std::optional<Record> read_record(const std::filesystem::path& rig) {
    if (!std::filesystem::exists(record_of(rig))) return std::nullopt;
    SettingsTable table = SettingsTable::from_file(record_of(rig));
    Record record{.date = table.text("date"), .rig_sha256 = table.text("rig_sha256")};
    for (SettingsTable& file : table.tables("file"))
        record.files.push_back({file.text("what"), file.text("text")});
    for (SettingsTable& item : table.tables("item"))
        record.items.push_back({item.text("name"), item.text("result")});
    return record;
}

MixerChange mixers_changed(const std::vector<Named>& then, const std::vector<Named>& now) {
    MixerChange all;
    for (const Named& mixer : then) {
        const auto found = std::ranges::find(now, mixer.what, &Named::what);
        if (!mixer.what.starts_with(mixer_of) || found == now.end()) continue;
        const std::vector<std::string> changes = mixer_changes(mixer.text, found->text);
        if (changes.empty()) continue;
        all.why += fmt::format("{}the {} has changed: {}", all.controls > 0 ? "; " : "", mixer.what,
                               fmt::join(changes, "; "));
        all.controls += static_cast<int>(changes.size());
    }
    if (all.controls > 0)
        all.why += "; \"shakerd check --restore-mixer\" sets it back, or commission the bench again with it";
    return all;
}

std::string missing_record(const std::filesystem::path& rig, const std::string& rig_text,
                           const std::vector<Named>& files) {
    const std::string remedy = "; run: shakerd check --commission --rig " + rig.string();
    std::optional<Record> record;
    try {
        record = read_record(rig);
    } catch (const InputError& e) {
        return e.what() + remedy;
    }
    if (!record)
        return "this bench has not been commissioned: there is no " + record_of(rig).string() + remedy;
    if (record->rig_sha256 != rig_hash(rig_text))
        return rig.string() + " has changed since the bench was commissioned" + remedy;
    for (const Named& now : files) {
        const auto then = std::ranges::find(record->files, now.what, &Named::what);
        if (now.what.starts_with(mixer_of)) continue;
        if (then == record->files.end())
            return "the record of the commissioning does not cover its " + now.what +
                   ", as those of earlier versions: commission the bench once more" + remedy;
        if (*then != now) return "its " + now.what + " has changed since the bench was commissioned" + remedy;
    }
    return mixers_changed(record->files, files).why;  // a record of an earlier version has none
}

}  // namespace shaker::commissioned
