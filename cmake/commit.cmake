# Fills in the commit of a source tree as @COMMIT@; leaves OUTPUT untouched if it already has that text.
#
#   cmake -DTREE=FOLDER -DINPUT=FILE -DOUTPUT=FILE -P commit.cmake
#
# The commit comes from the tree's own git, or in an archive that git made from commit.txt.
set(COMMIT unknown)
if(EXISTS ${TREE}/.git)
  # The explicit folders keep git from finding another repository around this tree, or from refusing that of another user.
  execute_process(
    COMMAND git --git-dir=${TREE}/.git --work-tree=${TREE} describe --always --exclude=* --abbrev=12 "--dirty=, modified"
    OUTPUT_VARIABLE described OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET RESULT_VARIABLE code)
  if(code STREQUAL 0)
    set(COMMIT ${described})
  endif()
elseif(EXISTS ${TREE}/cmake/commit.txt)
  file(STRINGS ${TREE}/cmake/commit.txt exported REGEX "^[0-9a-f]+$")
  if(exported)
    string(SUBSTRING ${exported} 0 12 COMMIT)
  endif()
endif()
configure_file(${INPUT} ${OUTPUT} @ONLY)
