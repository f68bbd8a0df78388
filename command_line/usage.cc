#include "command_line/usage.h"

#include <CLI/CLI.hpp>
#include <exception>
#include <iostream>
#include <sstream>
#include <string>
#include <vector>

#include "command_line/message.h"
#include "command_line/standard_streams.h"
#include "gluevo/nn/option_error.h"

namespace gluevo::apps {
namespace {

// The command that the command line names, as far as it names one.
const CLI::App& CommandOf(const CLI::App& app) {
  const std::vector<CLI::App*> commands = app.get_subcommands();
  return commands.empty() ? app : CommandOf(*commands.front());
}

bool HasCommands(const CLI::App& app) {
  return !app.get_subcommands([](const CLI::App*) { return true; }).empty();
}

std::string FullName(const CLI::App& app, const CLI::App& command) {
  return &command == &app ? app.get_name()
                          : FullName(app, *command.get_parent()) + " " + command.get_name();
}

std::string Commands(const CLI::App& app) {
  std::string list;
  for (const CLI::App* const command : app.get_subcommands([](const CLI::App*) { return true; })) {
    list += (list.empty() ? "" : ", ") + command->get_name();
  }
  return list;
}

std::string Positionals(const CLI::App& command) {
  std::string list;
  for (const CLI::Option* const option : command.get_options()) {
    if (option->get_positional()) {
      list += (list.empty() ? "" : " ") + option->get_name(/*positional=*/true);
    }
  }
  return list.empty() ? "none" : list;
}

std::string TextOfMissing(const CLI::App& command, const std::string& what) {
  const std::string name = what.substr(0, what.find(" is required"));
  const CLI::Option* const option = command.get_option_no_throw(name);
  return option == nullptr ? what : name + " is missing, expected: " + option->get_description();
}

std::string TextOfUnknown(const CLI::App& app, const CLI::App& command) {
  const std::vector<std::string> unknown = app.remaining(/*recurse=*/true);
  const std::string first = unknown.empty() ? "" : unknown.front();
  if (HasCommands(command) && !first.starts_with('-')) {
    return (first.empty() ? "no command" : Quoted(first) + " is no command") +
           ", expected one of " + Commands(command);
  }
  return first.starts_with('-')
             ? Quoted(first) + " is no option of " + FullName(app, command) +
                   ", expected one of those that --help lists"
             : Quoted(first) + " is one argument too many, expected " + Positionals(command);
}

// "--count: At Most 1 required but received 2" or "--count: 1 required INT missing".
std::string TextOfMismatch(const CLI::App& command, const std::string& what) {
  const std::string name = what.substr(0, what.find(':'));
  const CLI::Option* const option = command.get_option_no_throw(name);
  if (option == nullptr) {
    return what;
  }
  return option->count() > 1
             ? name + " is given " + std::to_string(option->count()) + " times, expected once"
             : name + " has no value, expected: " + option->get_description();
}

// Where to look for what options take.
std::string SeeHelp(const CLI::App& app) {
  return "; see " + FullName(app, CommandOf(app)) + " --help";
}

template <typename Kind>
bool Is(const CLI::ParseError& error) {
  return dynamic_cast<const Kind*>(&error) != nullptr;
}

// What was asked for, what was expected, and where to look.
std::string TextOf(const CLI::App& app, const CLI::ParseError& error) {
  const CLI::App& command = CommandOf(app);
  std::string text = error.what();
  // A mistyped option is why one that is needed is missing.
  if (Is<CLI::ExtrasError>(error) ||
      (Is<CLI::RequiredError>(error) && (HasCommands(command) || !app.remaining(true).empty()))) {
    text = TextOfUnknown(app, command);
  } else if (Is<CLI::RequiredError>(error)) {
    text = TextOfMissing(command, text);
  } else if (Is<CLI::ArgumentMismatch>(error)) {
    text = TextOfMismatch(command, text);
  } else if (Is<CLI::ExcludesError>(error)) {
    text += ", expected one of them";
  }
  return text + SeeHelp(app);
}

int RefuseUsage(const CLI::App& app, const std::string& text) {
  constexpr int kBadUsage = 2;
  PrintMessage(app.get_name() + ": error", text);
  return kBadUsage;
}

int Parse(CLI::App& app, int argc, char** argv) {
  int status = 0;
  try {
    app.parse(argc, argv);
  } catch (const CLI::Success& success) {
    // Not flushed by CLI11, which would lose the reason of a failure.
    std::ostringstream text;
    status = app.exit(success, text, text);
    std::cout << text.str();
  } catch (const CLI::ParseError& error) {
    status = RefuseUsage(app, TextOf(app, error));
  }
  CheckStandardOutput();
  return status;
}

}  // namespace

int RunCommandLine(CLI::App& app, int argc, char** argv) {
  PrepareStandardStreams();
  try {
    return Parse(app, argc, argv);
  } catch (const OptionError& error) {
    return RefuseUsage(app, error.what() + SeeHelp(app));
  } catch (const std::exception& error) {
    PrintMessage(app.get_name() + ": error", error.what());
    return 1;
  }
}

}  // namespace gluevo::apps
