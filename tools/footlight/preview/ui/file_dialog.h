// A dialog that opens a file, or asks where the rig is saved: folders, names, sizes and dates. Dear ImGui only.
#pragma once

#include <array>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "sim/core/result.h"
#include "tools/footlight/preview/ui/file_list.h"
#include "tools/footlight/preview/ui/folder_reader.h"

namespace footlight::tools {

class FileDialog {
 public:
  enum class Use { kOpen, kSave };
  struct Start {
    Use use = Use::kOpen;
    std::string folder;  // absolute
    std::string name;    // kSave: that is proposed
    std::string home;
    std::vector<FilePlace> places;
  };
  struct Chosen {
    Use use = Use::kOpen;
    std::string path;
    bool replaces = false;  // kSave: the user was asked, as there is such a file
  };

  // What is done with what was chosen. After an error the dialog stays, with its message.
  using Take = std::function<Status(const Chosen&)>;

  // At the next draw(). A folder that was shown before is shown again, unless start.name has another one.
  void open(Start start);
  // From open() on: keys belong to its field.
  [[nodiscard]] bool is_open() const { return opens_ || shown_; }
  // Once a picture, until `take` accepts what the user has chosen, or the user closes it by Esc. Typed words narrow the
  // list; Up, Down, Page Up and Page Down mark a row, Enter opens it or goes to what is typed as a path, Backspace in
  // an empty field goes to the folder above.
  void draw(float scale, const Take& take);

  [[nodiscard]] const std::string& folder() const { return start_.folder; }
  [[nodiscard]] const FileList& list() const { return list_; }

 private:
  void go(const std::string& folder, const std::string& marks = "");
  void read();
  void set_text(const std::string& text);
  void draw_field();
  void draw_places(float width, float height);
  void draw_list(float height, float scale);
  void draw_row(std::size_t row);
  void draw_foot(float scale);
  void take_keys();
  void act(std::size_t row);
  void enter();
  void choose(const std::string& path);
  void refuse(const Error& error);
  [[nodiscard]] bool saves() const { return start_.use == Use::kSave; }

  Start start_;
  FileList list_;
  std::unique_ptr<FolderReader> reader_;  // null: all of the folder is in the list
  std::string trouble_;                   // why it is not
  std::array<char, 1024> text_{};         // words, a path or a name
  int field_ = 0;                         // another one is another field, with the text that it begins with
  bool focuses_ = false;                  // the field is to have the keyboard
  bool scrolls_ = false;                  // to the marked row
  std::string asks_;                      // whether to replace this file
  std::optional<Chosen> chosen_;
  bool opens_ = false;
  bool shown_ = false;
  bool was_empty_ = true;  // the field, in the last picture
};

// Beside a file, with its name, the user's home folder, recent rigs and mounted media as places.
[[nodiscard]] FileDialog::Start file_start(FileDialog::Use use, const std::string& beside,
                                           const std::vector<std::string>& recent_rigs);

}  // namespace footlight::tools
