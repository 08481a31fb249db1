#include "daemon/sandbox/session_rights.hpp"

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "drivers/footage/lab_session.hpp"
#include "drivers/footage/media.hpp"

namespace shaker::sandbox {

namespace {

// A path cannot contain the character that ends each name.
constexpr char end_of_name = '\0';

void append_names(std::string& names, const std::vector<std::filesystem::path>& files, char kind) {
    for (const std::filesystem::path& file : files) names += kind + file.string() + end_of_name;
}

// Files that are opened to read a session.
struct SessionFiles {
    std::vector<std::filesystem::path> folders;  // whose names are read
    std::vector<std::filesystem::path> files;
    std::uint64_t bytes = 0;  // size of all
};

// Files that a session.toml names, as text for session_files().
std::string read_session_names(const std::filesystem::path& session) {
    const footage::NamedFiles named = named_files(footage::read_lab_session(session));
    std::string names;
    append_names(names, named.media, 'm');
    append_names(names, named.tables, 't');
    return names;
}

// Those of `names`, a text of read_session_names(). Only names and sizes are read.
SessionFiles session_files(const std::filesystem::path& session, std::string_view names) {
    SessionFiles all;
    all.files.push_back(session);
    for (std::size_t end = 0; (end = names.find(end_of_name)) != std::string_view::npos;
         names.remove_prefix(end + 1)) {
        const std::string_view name = names.substr(0, end);
        if (name.size() < 2) continue;
        std::vector<std::filesystem::path> files{name.substr(1)};
        if (name.front() == 'm') files = footage::media_files(files.front());
        std::error_code missing;  // reported when it is opened
        for (std::filesystem::path& file : files) {
            if (std::filesystem::is_directory(file, missing)) {
                all.folders.push_back(std::move(file));
                continue;
            }
            const std::uintmax_t size = std::filesystem::file_size(file, missing);
            all.bytes += missing ? 0 : size;
            all.files.push_back(std::move(file));
        }
    }
    return all;
}

}  // namespace

// Far above the needs of intact footage: 8 GiB of memory plus twice its files; 10 hours for each GiB of it.
SessionRights rights_for_session(const std::filesystem::path& session) {
    Confinement allowed = confinement_for(session);
    allowed.files.reads = {session};
    const Answer names = ask_confined(session.string(), allowed, [&] { return read_session_names(session); });
    if (names.status != manual::exit_ok) return {.status = names.status};
    allowed.warns = false;  // the first child did
    const SessionFiles files = session_files(session, names.text);
    allowed.files.lists = files.folders;
    allowed.files.reads = files.files;
    allowed.memory_bytes = (std::uint64_t{8} << 30U) + 2 * files.bytes;
    allowed.processor_s = 36000 * (1 + (files.bytes >> 30U));
    allowed.prepare = footage::load_decoders;
    return {.allowed = std::move(allowed)};
}

}  // namespace shaker::sandbox
