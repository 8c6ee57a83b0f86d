vacuform_test(coils_test
  SOURCES ${CMAKE_CURRENT_LIST_DIR}/array_layout_test.cpp ${CMAKE_CURRENT_LIST_DIR}/decoupling_test.cpp
          ${CMAKE_CURRENT_LIST_DIR}/coupling_matrix_test.cpp
          ${CMAKE_CURRENT_LIST_DIR}/geodesic_test.cpp
          ${CMAKE_CURRENT_LIST_DIR}/inductance_test.cpp
          ${CMAKE_CURRENT_LIST_DIR}/placement_test.cpp ${CMAKE_CURRENT_LIST_DIR}/segments_test.cpp
          ${CMAKE_CURRENT_LIST_DIR}/cut_lines_test.cpp
  LINKS vacuform_coils)
