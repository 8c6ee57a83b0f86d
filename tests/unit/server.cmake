vacuform_test(server_test
  SOURCES ${CMAKE_CURRENT_LIST_DIR}/store_test.cpp ${CMAKE_CURRENT_LIST_DIR}/http_parts_test.cpp
          ${CMAKE_CURRENT_LIST_DIR}/server_limits_test.cpp ${CMAKE_CURRENT_LIST_DIR}/server_api_test.cpp
  LINKS vacuform_service)
