#pragma once

#include <string>
#include <string_view>

namespace gluevo::apps {

/// Text as one line of a terminal: control characters, which names of files may hold and which
/// would end the line or steer the terminal, as \xNN.
std::string OneLine(std::string_view text);

/// "HEAD: TEXT" on a line of standard error. HEAD is the program's name and what it is: "gluevo:
/// warning".
void PrintMessage(std::string_view head, std::string_view text);

}  // namespace gluevo::apps
