#include "daemon/remote/web/page_files.hpp"

#include <fstream>
#include <iterator>

namespace shaker::web {

std::map<std::string, PageFile> read_page(const std::filesystem::path& folder) {
    std::map<std::string, PageFile> page;
    const auto add = [&](const char* path, const char* name, const char* type, std::string_view built_in) {
        if (folder.empty()) {
            page[path] = {type, std::string{built_in}};
        } else if (std::ifstream in{folder / name, std::ios::binary}) {
            page[path] = {type, std::string{std::istreambuf_iterator<char>{in}, {}}};
        }
    };
    add("/", "index.html", "text/html; charset=utf-8", built_in::index_html);
    add("/panel.js", "panel.js", "text/javascript; charset=utf-8", built_in::panel_js);
    add("/panel.css", "panel.css", "text/css; charset=utf-8", built_in::panel_css);
    return page;
}

}  // namespace shaker::web
