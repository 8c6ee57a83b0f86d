// The names by which the files of a model call each other: an OBJ its material library, that its images, a PLY its
// texture. Each is replaced by a number, and every other text is left out. Internal to api/redaction.
#pragma once

#include <map>
#include <string>
#include <string_view>

#include "api/base/error.hpp"

namespace vacuform {

// Numbers from 1 in the order in which the files name them.
class ModelNames {
 public:
  // Of an image, by its file name without folders, whatever the case. `file` says where the name is. Errors: corrupt_file
  // (an absolute path, or one to a parent folder).
  Result<int> texture(std::string_view path, const std::string& file);
  // Of a material, by its name, that the OBJ uses or that its library defines.
  int used_material(std::string_view name);
  int defined_material(std::string_view name);
  struct Material {
    int number = 0;
    bool used = false, defined = false;
  };
  const std::map<std::string, Material, std::less<>>& materials() const { return materials_; }
  // The images that a file names, with their numbers; and the name as the file has it.
  struct Texture {
    int number = 0;
    std::string path;  // empty: no file names it
  };
  const std::map<std::string, Texture>& textures() const { return textures_; }
  // Of an image in the archive, which no file has to name. Nothing if another has that name.
  int texture_there(std::string_view path);

 private:
  Texture& entry(std::string_view path);
  std::map<std::string, Texture> textures_;
  Material& material(std::string_view name);
  std::map<std::string, Material, std::less<>> materials_;
};

// A path of an archive or of a file in it, whose steps are then separated by '/'. Errors: corrupt_file (as above).
Result<std::string> plain_path(std::string_view path, const std::string& where);

// One line without its end. What is left of it goes to `out`, with an end; other lines become empty, so that they keep
// their numbers.
class ModelLines {
 public:
  enum class Kind { obj, mtl };
  // Keeps a reference to the names.
  ModelLines(Kind kind, ModelNames& names) : kind_(kind), names_(names) {}
  Result<void> take(std::string_view line, std::string& out);

 private:
  void obj(std::string_view word, std::string_view rest, std::string& out);
  Result<void> mtl(std::string_view word, std::string_view rest, std::string& out);
  Result<void> map(std::string_view rest, std::string& out);

  const Kind kind_;
  ModelNames& names_;
  std::uint64_t line_ = 0;
  bool goes_on_ = false;
};

}  // namespace vacuform
