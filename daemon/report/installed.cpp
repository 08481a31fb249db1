#include "daemon/report/installed.hpp"

namespace shaker::report {

std::filesystem::path installed(std::string_view name) {
    const std::filesystem::path program = std::filesystem::read_symlink("/proc/self/exe").parent_path();
    for (const auto& folder : {program.parent_path() / "share/shakerd" / name, program / name})
        if (std::filesystem::is_directory(folder)) return std::filesystem::canonical(folder);
    return {};
}

}  // namespace shaker::report
