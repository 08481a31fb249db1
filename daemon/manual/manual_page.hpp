#pragma once
// The manual page of a program, made from its tables, in the macros of man(7).
#include <cstddef>
#include <string>
#include <string_view>

#include "daemon/manual/command.hpp"

namespace shaker::manual {

/// The words of a text in lines of at most `width` characters, the last without its end.
std::string filled(std::string_view text, std::size_t width);

/// Text of a manual page.
/// Line ends in the texts count as blanks.
class ManualPage {
public:
    /// name: "shakerctl"; number: part of the manual, 1 or 8; what: one line without a full stop.
    ManualPage(std::string_view name, int number, std::string_view what);

    void section(std::string_view title);
    void paragraph(std::string_view text);
    /// A command line: `name` in bold, then `rest`.
    void call(std::string_view name, std::string_view rest);
    /// A term in bold, then its value in italics, then its meaning.
    void item(std::string_view term, std::string_view value, std::string_view meaning);
    /// Indents everything until leave(): it belongs to the item above.
    void enter();
    void leave();
    /// Lines that are not filled.
    void example(std::string_view lines);

    [[nodiscard]] const std::string& text() const noexcept { return text_; }

private:
    void begin();

    std::string text_;
    bool fresh_ = false;  // the last call was section()
};

/// In the macros of man(7).
std::string manual_page(const Program& program);

}  // namespace shaker::manual
