#pragma once
// The files of the operator's page, from a folder or from the program itself.
#include <filesystem>
#include <map>
#include <string>
#include <string_view>

namespace shaker::web {

/// A file of the page.
struct PageFile {
    std::string type;  // "text/html; charset=utf-8"
    std::string content;
};

/// The files by path: "/". Those of index.html, panel.js and panel.css that exist in the folder; without a
/// folder those of the program.
std::map<std::string, PageFile> read_page(const std::filesystem::path& folder);

/// The page in the program. CMake makes the definitions from daemon/remote/panel/bundle.
namespace built_in {
extern const std::string_view index_html, panel_js, panel_css;
}

}  // namespace shaker::web
