#pragma once
// A manual page in the words of man(7).
#include <cstddef>
#include <string>
#include <string_view>

namespace shaker {

/// The words of a text in lines of at most `width` characters, the last without its end.
std::string filled(std::string_view text, std::size_t width);

/// Of the texts line ends are blanks.
class ManualPage {
public:
    /// name: "shakerctl"; number: of the manual's part, 1 or 8; what: one line without a full stop.
    ManualPage(std::string_view name, int number, std::string_view what);

    void section(std::string_view title);
    void paragraph(std::string_view text);
    /// A call: `name` in bold, `rest` as it is.
    void call(std::string_view name, std::string_view rest);
    /// A term in bold, then what it takes in italics, then what it means.
    void item(std::string_view term, std::string_view takes, std::string_view meaning);
    /// What follows belongs to the item above, until it is left.
    void enter();
    void leave();
    /// Lines as they are.
    void example(std::string_view lines);

    [[nodiscard]] const std::string& text() const noexcept { return text_; }

private:
    void begin();

    std::string text_;
    bool fresh_ = false;  // nothing stands behind the last title
};

}  // namespace shaker
